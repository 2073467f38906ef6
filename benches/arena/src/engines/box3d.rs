//! Box3D through raw bindings. Knob: sub-steps per step.

use crate::engine::{Engine, Entry, Settings, State};
use crate::scene::Scene;
use box3d_sys::*;
use glam::{Quat, Vec3};

struct Box3d {
    world: b3WorldId,
    bodies: Vec<b3BodyId>,
    dt: f32,
    substeps: i32,
}

pub(crate) fn entry() -> Entry {
    Entry::numbered("box3d", "substeps", 4, &[1, 2, 4, 8, 16], build)
}

fn v(p: Vec3) -> b3Vec3 {
    b3Vec3 {
        x: p.x,
        y: p.y,
        z: p.z,
    }
}

fn vec(p: b3Vec3) -> Vec3 {
    Vec3::new(p.x, p.y, p.z)
}

fn build(scene: &Scene, settings: &Settings) -> Box<dyn Engine> {
    // SAFETY: plain C calls; ids stay valid until the world is destroyed in `drop`.
    unsafe {
        let mut def = b3DefaultWorldDef();
        def.gravity = v(scene.gravity);
        def.enableSleep = settings.sleeping;
        def.workerCount = settings.threads as u32;
        let world = b3CreateWorld(&def);
        let mut bodies = Vec::new();
        for b in &scene.bodies {
            let mut def = b3DefaultBodyDef();
            def.type_ = if b.fixed {
                b3BodyType_b3_staticBody
            } else {
                b3BodyType_b3_dynamicBody
            };
            def.position = v(b.pos);
            def.rotation = b3Quat {
                v: v(b.rot.xyz()),
                s: b.rot.w,
            };
            def.linearVelocity = v(b.linvel);
            def.angularVelocity = v(b.angvel);
            def.isBullet = b.bullet;
            let body = b3CreateBody(world, &def);
            let mut def = b3DefaultShapeDef();
            def.density = b.density;
            def.baseMaterial.friction = scene.friction;
            def.baseMaterial.restitution = scene.restitution;
            let shape = &scene.shapes[b.shape];
            if let Some(h) = shape.half_extents {
                let hull = b3MakeBoxHull(h.x, h.y, h.z);
                b3CreateHullShape(body, &def, (&raw const hull).cast());
            } else {
                let points: Vec<_> = shape.points.iter().map(|&p| v(p)).collect();
                let n = points.len() as i32;
                let hull = b3CreateHull(points.as_ptr(), n, n);
                assert!(!hull.is_null(), "hull");
                b3CreateHullShape(body, &def, hull);
                b3DestroyHull(hull);
            }
            bodies.push(body);
        }
        Box::new(Box3d {
            world,
            bodies,
            dt: scene.dt,
            substeps: settings.value as i32,
        })
    }
}

impl Engine for Box3d {
    fn step(&mut self) {
        // SAFETY: the world is alive.
        unsafe { b3World_Step(self.world, self.dt, self.substeps) }
    }

    fn read(&self, out: &mut Vec<State>) {
        out.extend(self.bodies.iter().map(|&b| {
            // SAFETY: the world and its bodies are alive.
            let (p, q, l, a) = unsafe {
                (
                    b3Body_GetPosition(b),
                    b3Body_GetRotation(b),
                    b3Body_GetLinearVelocity(b),
                    b3Body_GetAngularVelocity(b),
                )
            };
            State {
                pos: vec(p),
                rot: Quat::from_xyzw(q.v.x, q.v.y, q.v.z, q.s),
                linvel: vec(l),
                angvel: vec(a),
            }
        }));
    }

    fn num_awake(&self) -> Option<usize> {
        // SAFETY: the world is alive.
        Some(unsafe { b3World_GetAwakeBodyCount(self.world) } as usize)
    }
}

impl Drop for Box3d {
    fn drop(&mut self) {
        // SAFETY: created in `build`, destroyed once.
        unsafe { b3DestroyWorld(self.world) }
    }
}
