//! Which triangles of a level a shape may touch on its way: it is followed to what it touches first, and from there along that.

use crate::contact::narrow::level::{Ground, LevelPair, SHALLOW, TOUCH};
use crate::contact::narrow::level_scratch::{Approach, LevelScratch};
use crate::geometry::distance::CoreCast;
use crate::geometry::support::{Core, PlacedCore};
use crate::math::{Aabb, Pose};
use glam::Vec3;

/// How far a hull may come nearer to a triangle within the step without being followed to it, as a share of its diagonal: contacts
/// reach farther.
const GRAZING: f32 = 1e-4;

/// How deep what is round may lie in a triangle and is lifted out of it to be followed, as a share of its diagonal.
const SUNK: f32 = 0.01;

/// How often a hull is followed to what it touches within a step.
const MAX_STOPS: usize = 4;

/// A shape at the start of a part of its way, axes of the level, from the origin of the shape's frame.
struct Mover<'s> {
    core: PlacedCore<'s>,
    /// Around the core, m.
    radius: f32,
    size: f32,
    way: Vec3,
}

/// What a shape touches first on its way.
#[derive(Clone, Copy, Debug)]
struct FirstTouch {
    /// Share of the way.
    share: f32,
    normal: Vec3,
}

impl LevelPair<'_> {
    /// Fills `scratch.near` with the triangles that the shape, around which this is the box, may touch on its way, and `scratch.stops`
    /// with where it is deflected: there it goes on along what it has met.
    pub(in crate::contact::narrow) fn follow(&self, tight: Aabb, scratch: &mut LevelScratch) {
        scratch.near.clear();
        scratch.stops.clear();
        let size = self.shape.aabb().diagonal();
        let (mut shift, mut way) = (Vec3::ZERO, self.travel);
        for part in 0..MAX_STOPS {
            self.look_ahead(tight, (shift, way), scratch);
            if part == 0 {
                shift = self.lift(scratch);
            }
            scratch.near.extend_from_slice(&scratch.ahead);
            if part > 0 {
                // In the order of the mesh, whatever its tree is like.
                scratch.near.sort_unstable_by_key(|&leaf| self.number(leaf));
                scratch.near.dedup();
            }
            if way.length() <= SHALLOW * size {
                return;
            }
            let Some(FirstTouch { share, normal }) = self.first_touch(shift, way, scratch) else {
                return;
            };
            shift += share * way;
            way *= 1.0 - share;
            way -= way.dot(normal).min(0.0) * normal;
            if share > 0.0 {
                scratch.stops.push(shift);
            }
        }
    }

    /// The number of a triangle in the list that the level was made from: contacts are in this order.
    fn number(&self, leaf: u32) -> u32 {
        self.mesh.triangles()[leaf as usize].index
    }

    /// Fills `scratch.ahead` with the triangles near a way that begins at a shift.
    fn look_ahead(&self, tight: Aabb, (shift, way): (Vec3, Vec3), scratch: &mut LevelScratch) {
        let place = self.hull_in_mesh.position + shift;
        let swept = Aabb {
            min: place + tight.min + way.min(Vec3::ZERO),
            max: place + tight.max + way.max(Vec3::ZERO),
        };
        let ahead = &mut scratch.ahead;
        ahead.clear();
        self.mesh
            .tree()
            .within(self.mesh.triangles(), &swept.fattened(self.reach), |leaf| {
                ahead.push(leaf);
            });
        ahead.sort_unstable_by_key(|&leaf| self.number(leaf));
    }

    /// How far what is round is lifted to touch what it lies in by a little, m. By its sag already it would meet a hollow edge before it is
    /// over what rises beyond, and then not be followed on to that; what goes up a bowl so gained energy in each step, from overlap that was
    /// pushed out.
    fn lift(&self, scratch: &LevelScratch) -> Vec3 {
        let Some(round) = self.shape.round() else {
            return Vec3::ZERO;
        };
        let pose = Pose::new(Vec3::ZERO, self.hull_in_mesh.rotation);
        let core = PlacedCore::new(round.core(), &pose);
        let deepest = SUNK * self.shape.aabb().diagonal();
        let mut lift = Vec3::ZERO;
        for &leaf in &scratch.ahead {
            let Some(ground) = self.ground(&self.mesh.triangles()[leaf as usize]) else {
                continue;
            };
            let foot = core.support(-ground.normal.as_dvec3()).as_vec3() + lift;
            let depth = round.radius - ground.height(foot);
            if depth > 0.0 && depth < deepest && ground.is_over(foot) {
                lift += depth * ground.normal;
            }
        }
        lift
    }

    /// What of `scratch.ahead` the shape touches first on a way, begun at a shift.
    ///
    /// Most land on the inside of a triangle with the point that is lowest over it, which is found without a search; the others can be
    /// left out as soon as it is known that something else is touched before their plane is reached.
    fn first_touch(
        &self,
        shift: Vec3,
        way: Vec3,
        scratch: &mut LevelScratch,
    ) -> Option<FirstTouch> {
        let round = self.shape.round();
        let core = round.map_or_else(|| Core::of_hull(self.shape.hull()), |round| round.core());
        let mover = Mover {
            core: PlacedCore::new(core, &Pose::new(shift, self.hull_in_mesh.rotation)),
            radius: round.map_or(0.0, |round| round.radius),
            size: self.shape.aabb().diagonal(),
            way,
        };
        let LevelScratch {
            ahead, approaches, ..
        } = scratch;
        let first = self.first_landing(&mover, ahead, approaches);
        match first {
            Some(FirstTouch { share: 0.0, .. }) => first,
            _ => self.first_cast(&mover, approaches, first),
        }
    }

    /// The first triangle of `ahead` that the shape lands on with its lowest point. Fills `approaches` with those that it may touch
    /// otherwise, unless it lands at once.
    fn first_landing(
        &self,
        mover: &Mover,
        ahead: &[u32],
        approaches: &mut Vec<Approach>,
    ) -> Option<FirstTouch> {
        let touch = TOUCH * mover.size;
        let mut first: Option<FirstTouch> = None;
        approaches.clear();
        for &leaf in ahead {
            let Some(ground) = self.ground(&self.mesh.triangles()[leaf as usize]) else {
                continue;
            };
            let normal = ground.normal;
            let rate = -normal.dot(mover.way);
            if rate <= GRAZING * mover.size {
                continue;
            }
            // What does not get down to the plane does not get to the triangle; what is on it already gets no farther.
            let foot = mover.core.support(-normal.as_dvec3()).as_vec3();
            let height = ground.height(foot) - mover.radius;
            if height > rate + touch {
                continue;
            }
            let share = (height - 0.5 * touch) / rate;
            if height <= touch {
                if ground.is_over(foot) {
                    return Some(FirstTouch { share: 0.0, normal });
                }
            } else if ground.is_over(foot + share * mover.way) {
                if first.is_none_or(|first| share < first.share) {
                    first = Some(FirstTouch { share, normal });
                }
                continue;
            }
            approaches.push(Approach {
                leaf,
                share: share.max(0.0),
            });
        }
        first
    }

    /// The first touch of all: `first`, or one that a cast finds before it.
    fn first_cast(
        &self,
        mover: &Mover,
        approaches: &[Approach],
        mut first: Option<FirstTouch>,
    ) -> Option<FirstTouch> {
        let (length, touch) = (mover.way.length(), TOUCH * mover.size);
        let mut cast = CoreCast {
            direction: (mover.way / length).as_dvec3(),
            free: 0.0,
            length: f64::from(length),
            radius: f64::from(mover.radius),
            touch: f64::from(touch),
        };
        if let Some(first) = first {
            // What is touched at the same time does not count.
            cast.length = f64::from((first.share * length - 2.0 * touch).max(0.0));
        }
        for &Approach { leaf, share } in approaches {
            if f64::from(share * length) > cast.length {
                continue;
            }
            let ground = self.ground(&self.mesh.triangles()[leaf as usize]);
            let Some(ground) = ground.filter(|ground| !mover.passes_beside(ground)) else {
                continue;
            };
            if let Some(touch) = cast.first_touch(&Core::of_triangle(ground.corners), &mover.core) {
                cast.length = touch.distance;
                let normal = touch.nearest.map(|nearest| nearest.normal.as_vec3());
                first = Some(FirstTouch {
                    share: (touch.distance / f64::from(length)) as f32,
                    normal: normal.unwrap_or(ground.normal),
                });
            }
        }
        first
    }
}

impl Mover<'_> {
    /// Whether the shape comes down beside a triangle, and so does not get there.
    fn passes_beside(&self, ground: &Ground) -> bool {
        (0..3).any(|edge| {
            let (from, outward) = ground.border(edge);
            let nearest = self.core.support(-outward.as_dvec3()).as_vec3();
            let beyond = outward.dot(nearest - from) + outward.dot(self.way).min(0.0);
            beyond > self.radius + TOUCH * (self.size + from.abs().max_element())
        })
    }
}
