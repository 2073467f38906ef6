//! Scenes as text: a failing scene is kept as a file that anyone can read and a test replays.
//!
//! A line is a word and what belongs to it; `#` starts a comment. `body` starts a body, and what is not said of it is
//! that of [`Actor::new`]. Numbers are written so that they are read back to the bit.

use super::laws::Law;
use super::scene::{Actor, Form, Ground, Role, Scene, Smooth};
use bevy_cleave::prelude::*;
use glam::{Quat, Vec3};
use std::fmt::Write;

const KINDS: [(RigidBody, &str); 3] = [
    (RigidBody::Dynamic, "dynamic"),
    (RigidBody::Kinematic, "kinematic"),
    (RigidBody::Static, "static"),
];

/// The scene as text, below comments that say why it is kept.
pub(crate) fn write(scene: &Scene, comments: &[String]) -> String {
    let mut text = String::new();
    for comment in comments {
        line(&mut text, "#", comment);
    }
    line(&mut text, "family", &scene.family);
    line(&mut text, "seed", &scene.seed.to_string());
    let laws: Vec<_> = scene.laws.iter().map(|law| law.name()).collect();
    line(&mut text, "laws", &laws.join(" "));
    vector(&mut text, "gravity", scene.gravity);
    line(&mut text, "rate", &scene.rate.to_string());
    if scene.soft > 0 {
        line(&mut text, "soft", &scene.soft.to_string());
    }
    line(&mut text, "steps", &scene.steps.to_string());
    for actor in &scene.actors {
        write_actor(&mut text, actor);
    }
    text
}

fn line(text: &mut String, word: &str, rest: &str) {
    writeln!(text, "{word} {rest}").expect("a string takes all");
}

fn vector(text: &mut String, word: &str, v: Vec3) {
    line(text, word, &format!("{} {} {}", v.x, v.y, v.z));
}

fn write_actor(text: &mut String, actor: &Actor) {
    let usual = Actor::new(actor.form.clone(), Vec3::ZERO);
    let kind = name_of(&KINDS, actor.kind);
    let role = name_of(&Role::NAMES, actor.role);
    line(text, "\nbody", &format!("{kind} {role}"));
    write_form(text, &actor.form);
    vector(text, "at", actor.pose.position);
    let [x, y, z, w] = actor.pose.rotation.to_array();
    if actor.pose.rotation != usual.pose.rotation {
        line(text, "turn", &format!("{x} {y} {z} {w}"));
    }
    let motion = [("linear", actor.linear), ("angular", actor.angular)];
    for (word, v) in motion.into_iter().filter(|(_, v)| *v != Vec3::ZERO) {
        vector(text, word, v);
    }
    let numbers = [
        ("density", actor.density, usual.density),
        ("friction", actor.friction, usual.friction),
        ("restitution", actor.restitution, usual.restitution),
    ];
    for (word, number, _) in numbers.into_iter().filter(|(_, n, usual)| n != usual) {
        line(text, word, &number.to_string());
    }
}

fn write_form(text: &mut String, form: &Form) {
    match form {
        Form::Box(size) => vector(text, "box", *size),
        Form::HalfSpace(normal) => vector(text, "half_space", *normal),
        Form::Hull(corners) => corners.iter().for_each(|c| vector(text, "corner", *c)),
        Form::Smooth(kind, [radius, length]) => {
            line(
                text,
                name_of(&Smooth::NAMES, *kind),
                &format!("{radius} {length}"),
            );
        }
        Form::Rounded(core, radius) => {
            write_form(text, core);
            line(text, "rounded", &radius.to_string());
        }
        Form::Compound(parts) => parts.iter().for_each(|(form, pose)| {
            let [x, y, z] = pose.position.to_array();
            let [i, j, k, w] = pose.rotation.to_array();
            line(text, "part", &format!("{x} {y} {z} {i} {j} {k} {w}"));
            write_form(text, form);
        }),
        Form::Ground(ground) => {
            line(
                text,
                "ground",
                &format!("{} {}", ground.columns, ground.spacing),
            );
            for row in ground.heights.chunks(ground.columns) {
                let row: Vec<_> = row.iter().map(f32::to_string).collect();
                line(text, "row", &row.join(" "));
            }
        }
    }
}

fn name_of<T: Copy + PartialEq>(names: &[(T, &'static str)], value: T) -> &'static str {
    let found = names.iter().find(|(listed, _)| *listed == value);
    found.expect("every value is listed").1
}

fn value_of<T: Copy>(names: &[(T, &'static str)], name: &str) -> Result<T, String> {
    let found = names.iter().find(|(_, listed)| *listed == name);
    found.map(|(value, _)| *value).ok_or(format!("no {name}"))
}

/// Reads what [`write`] writes.
///
/// # Errors
/// The line that makes no sense.
pub(crate) fn read(text: &str) -> Result<Scene, String> {
    let mut scene = Scene {
        family: String::new(),
        seed: 0,
        laws: Vec::new(),
        gravity: Vec3::ZERO,
        rate: 60.0,
        soft: 0,
        steps: 0,
        actors: Vec::new(),
    };
    let lines = text
        .lines()
        .map(|line| line.split('#').next().unwrap_or(""));
    for line in lines.filter(|line| !line.trim().is_empty()) {
        let mut words = line.split_whitespace();
        let word = words.next().unwrap_or("");
        let rest: Vec<&str> = words.collect();
        read_line(&mut scene, word, &rest).map_err(|error| format!("{line}: {error}"))?;
    }
    Ok(scene)
}

fn read_line(scene: &mut Scene, word: &str, rest: &[&str]) -> Result<(), String> {
    match (word, rest) {
        ("family", [family]) => scene.family = (*family).into(),
        ("seed", [seed]) => scene.seed = seed.parse().map_err(|_| "no number")?,
        ("laws", laws) => {
            let laws = laws.iter().map(|name| value_of(&Law::ALL, name));
            scene.laws = laws.collect::<Result<_, _>>()?;
        }
        ("gravity", _) => scene.gravity = Vec3::from_array(numbers(rest)?),
        ("rate", _) => [scene.rate] = numbers(rest)?,
        ("soft", [parts]) => scene.soft = parts.parse().map_err(|_| "no number")?,
        ("steps", [steps]) => scene.steps = steps.parse().map_err(|_| "no number")?,
        ("body", [kind, role]) => scene.actors.push(Actor {
            kind: value_of(&KINDS, kind)?,
            role: value_of(&Role::NAMES, role)?,
            ..Actor::new(Form::Hull(Vec::new()), Vec3::ZERO)
        }),
        _ => {
            let actor = scene.actors.last_mut().ok_or("not in a body")?;
            read_actor(actor, word, rest)?;
        }
    }
    Ok(())
}

fn read_actor(actor: &mut Actor, word: &str, rest: &[&str]) -> Result<(), String> {
    match word {
        "at" => actor.pose.position = Vec3::from_array(numbers(rest)?),
        "turn" => actor.pose.rotation = Quat::from_array(numbers(rest)?),
        "linear" => actor.linear = Vec3::from_array(numbers(rest)?),
        "angular" => actor.angular = Vec3::from_array(numbers(rest)?),
        "density" => [actor.density] = numbers(rest)?,
        "friction" => [actor.friction] = numbers(rest)?,
        "restitution" => [actor.restitution] = numbers(rest)?,
        "part" => {
            let [x, y, z, i, j, k, w] = numbers(rest)?;
            let pose = Pose::new(Vec3::new(x, y, z), Quat::from_xyzw(i, j, k, w));
            if !matches!(actor.form, Form::Compound(_)) {
                actor.form = Form::Compound(Vec::new());
            }
            if let Form::Compound(parts) = &mut actor.form {
                parts.push((Form::Hull(Vec::new()), pose));
            }
        }
        _ => {
            let form = match &mut actor.form {
                Form::Compound(parts) => &mut parts.last_mut().ok_or("no part")?.0,
                form => form,
            };
            read_form(form, word, rest)?;
        }
    }
    Ok(())
}

fn read_form(form: &mut Form, word: &str, rest: &[&str]) -> Result<(), String> {
    match (word, form) {
        ("box", form) => *form = Form::Box(Vec3::from_array(numbers(rest)?)),
        ("half_space", form) => *form = Form::HalfSpace(Vec3::from_array(numbers(rest)?)),
        ("corner", Form::Hull(corners)) => corners.push(Vec3::from_array(numbers(rest)?)),
        ("rounded", form) => {
            let [radius] = numbers(rest)?;
            *form = Form::Rounded(Box::new(form.clone()), radius);
        }
        ("ground", form) => {
            let [columns, spacing] = numbers(rest)?;
            *form = Form::Ground(Ground {
                heights: Vec::new(),
                columns: columns as usize,
                spacing,
            });
        }
        ("row", Form::Ground(ground)) => {
            for height in rest {
                ground
                    .heights
                    .push(height.parse().map_err(|_| "no number")?);
            }
        }
        (word, form) => {
            let kind = value_of(&Smooth::NAMES, word)?;
            *form = Form::Smooth(kind, numbers(rest)?);
        }
    }
    Ok(())
}

fn numbers<const N: usize>(words: &[&str]) -> Result<[f32; N], String> {
    let numbers: Result<Vec<f32>, _> = words.iter().map(|word| word.parse()).collect();
    let numbers = numbers.map_err(|_| "no number")?;
    numbers.try_into().map_err(|_| format!("not {N} numbers"))
}
