//! Questions to a heap after each step, and somebody who walks against it.

use crate::heaps::{H, plain, run, step};
use crate::pair::{Pair, Row, Step};
use bevy_cleave::prelude::*;
use glam::Vec3;

/// Rays and casts after each step, from above into the heap.
const QUESTIONS: u16 = 100;

/// The heap, and the same with questions after each step: 1 to [`QUESTIONS`].
fn asked(ask: impl Fn(&Queries, Vec3) + 'static) -> Pair {
    let mut simulation = plain();
    let with = Box::new(move || {
        simulation.step(H);
        let queries = simulation.queries();
        for i in 0..QUESTIONS {
            let above = Vec3::new(f32::from(i % 10), 50.0, f32::from(i / 10));
            ask(&queries, 0.6 * above);
        }
    });
    Pair::new(step(plain()), with)
}

fn a_shape() -> QueryShape<'static> {
    QueryShape::cuboid(Vec3::splat(0.4)).expect("usable")
}

pub(crate) fn rows() -> Vec<Row> {
    vec![
        Row::new("Queries", "an index and a ray after each step", || {
            let mut simulation = plain();
            let ray = Ray::new(Vec3::new(0.1, 50.0, 0.1), Vec3::NEG_Y, 100.0).expect("usable");
            let with = Box::new(move || {
                simulation.step(H);
                let hit = simulation.queries().cast_ray(&ray, &QueryFilter::all());
                std::hint::black_box(hit);
            });
            Pair::new(step(plain()), with)
        }),
        Row::new("Queries", "100 rays after each step", || {
            asked(|queries, above| {
                let ray = Ray::new(above, Vec3::NEG_Y, 100.0).expect("usable");
                std::hint::black_box(queries.cast_ray(&ray, &QueryFilter::all()));
            })
        }),
        Row::new("Queries", "100 casts of a box after each step", || {
            asked(|queries, above| {
                let from = Pose::from_position(above);
                let cast = ShapeCast::new(a_shape(), from, Vec3::NEG_Y, 100.0).expect("usable");
                std::hint::black_box(queries.cast_shape(&cast, &QueryFilter::all()));
            })
        }),
        Row::new(
            "Queries",
            "100 places of a box after each step, what it overlaps",
            || {
                asked(|queries, above| {
                    let place = Pose::from_position(above.with_y(0.5));
                    let mut found = Vec::new();
                    queries
                        .overlap_shape(&a_shape(), &place, &QueryFilter::all(), &mut found)
                        .expect("usable");
                    std::hint::black_box(found);
                })
            },
        ),
        Row::new(
            "Characters",
            "100 boxes that are moved by 1 m and slide, after each step",
            || {
                asked(|queries, above| {
                    let slider = Slider {
                        shape: a_shape(),
                        skin: 0.01,
                    };
                    let start = Pose::from_position(above.with_y(2.0));
                    let motion = Vec3::new(0.6, -0.8, 0.0);
                    let mut met = Vec::new();
                    let slid = queries.move_and_slide(
                        &slider,
                        start,
                        motion,
                        &QueryFilter::all(),
                        &mut met,
                    );
                    std::hint::black_box(slid);
                })
            },
        ),
        Row::new(
            "Characters",
            "one that walks against the heap in each step",
            || Pair::new(step(plain()), walking()),
        ),
        Row::new("Sleep", "on, and the heap rests", || {
            let mut asleep = plain();
            asleep.config.sleep = SleepConfig::default();
            run(&mut asleep, 600);
            Pair::new(step(plain()), step(asleep))
        }),
    ]
}

/// A capsule that walks towards the heap, which is in its way.
fn walking() -> Step {
    let mut simulation = plain();
    let capsule = ConvexMesh::capsule(0.3, 0.5).expect("valid size");
    let settings = WalkSettings::default();
    let mut state = WalkState {
        position: Vec3::new(-3.0, 0.6, 2.0),
        ..WalkState::default()
    };
    let input = WalkInput {
        velocity: Vec3::X,
        jump: 0.0,
        gravity: 9.81 * Vec3::NEG_Y,
        step_dt: H,
    };
    let mut pushes = Vec::new();
    Box::new(move || {
        simulation.step(H);
        let slider = Slider {
            shape: QueryShape::from(&capsule),
            skin: settings.skin,
        };
        simulation.queries().walk(
            (&slider, &settings),
            &mut state,
            &input,
            &QueryFilter::all(),
            &mut pushes,
        );
    })
}
