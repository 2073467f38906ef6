//! Box3D through raw bindings. Knob: sub-steps per step. Joints of `box3d-stiff` are as stiff as the solver lets them be, a quarter of
//! the frequency of sub-steps, instead of 60 Hz.

use crate::engine::{Engine, Entry, Settings, State};
use crate::scene::{self, JointKind, Scene};
use box3d_sys::*;
use glam::{Quat, Vec3};

struct Box3d {
    world: b3WorldId,
    bodies: Vec<b3BodyId>,
    dt: f32,
    substeps: i32,
}

pub(crate) fn entries() -> [Entry; 2] {
    let values = [1, 2, 4, 8, 16];
    [
        Entry::numbered("box3d", "substeps", 4, &values, |scene, settings| {
            build(scene, settings, None)
        }),
        Entry::numbered("box3d-stiff", "substeps", 4, &values, |scene, settings| {
            build(scene, settings, Some(f32::MAX))
        })
        .for_joints(),
    ]
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

/// `hertz`: of joints, if not as Box3D has it.
fn build(scene: &Scene, settings: &Settings, hertz: Option<f32>) -> Box<dyn Engine> {
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
        for joint in &scene.joints {
            let made = add_joint(world, joint, joint.bodies.map(|body| bodies[body]));
            if let Some(hertz) = hertz {
                let (mut old, mut damping_ratio) = (0.0, 0.0);
                b3Joint_GetConstraintTuning(made, &mut old, &mut damping_ratio);
                b3Joint_SetConstraintTuning(made, hertz, damping_ratio);
            }
        }
        Box::new(Box3d {
            world,
            bodies,
            dt: scene.dt,
            substeps: settings.value as i32,
        })
    }
}

/// The frames of a joint, whose x axis is to be `axis` of Box3D's.
fn frames(base: &mut b3JointDef, joint: &scene::Joint, bodies: [b3BodyId; 2], axis: Vec3) {
    let turned = Quat::from_rotation_arc(axis, Vec3::X);
    let [on_a, on_b] = joint.frames.map(|frame| {
        let rot = frame.rot * turned;
        b3Transform {
            p: v(frame.pos),
            q: b3Quat {
                v: v(rot.xyz()),
                s: rot.w,
            },
        }
    });
    (base.bodyIdA, base.bodyIdB) = (bodies[0], bodies[1]);
    (base.localFrameA, base.localFrameB) = (on_a, on_b);
}

/// Adds a joint of a scene.
///
/// # Safety
/// World and bodies are alive.
unsafe fn add_joint(world: b3WorldId, joint: &scene::Joint, bodies: [b3BodyId; 2]) -> b3JointId {
    // SAFETY: plain C calls with definitions that live as long as these.
    unsafe {
        match joint.kind {
            JointKind::Fixed => {
                let mut def = b3DefaultWeldJointDef();
                frames(&mut def.base, joint, bodies, Vec3::X);
                b3CreateWeldJoint(world, &def)
            }
            JointKind::Ball => {
                let mut def = b3DefaultSphericalJointDef();
                frames(&mut def.base, joint, bodies, Vec3::Z);
                b3CreateSphericalJoint(world, &def)
            }
            JointKind::ConeTwist { swing, twist } => {
                let mut def = b3DefaultSphericalJointDef();
                frames(&mut def.base, joint, bodies, Vec3::Z);
                (def.enableConeLimit, def.coneAngle) = (true, swing);
                def.enableTwistLimit = true;
                (def.lowerTwistAngle, def.upperTwistAngle) = (-twist, twist);
                b3CreateSphericalJoint(world, &def)
            }
            JointKind::Hinge { range, motor } => {
                let mut def = b3DefaultRevoluteJointDef();
                frames(&mut def.base, joint, bodies, Vec3::Z);
                if let Some([least, most]) = range {
                    def.enableLimit = true;
                    (def.lowerAngle, def.upperAngle) = (least, most);
                }
                if let Some(motor) = motor {
                    def.enableMotor = true;
                    (def.motorSpeed, def.maxMotorTorque) = (motor.speed, motor.max_torque);
                }
                b3CreateRevoluteJoint(world, &def)
            }
            JointKind::Slider { spring } => {
                let mut def = b3DefaultPrismaticJointDef();
                frames(&mut def.base, joint, bodies, Vec3::X);
                if let Some(spring) = spring {
                    def.enableSpring = true;
                    (def.hertz, def.dampingRatio) = (spring.hertz, spring.damping_ratio);
                }
                b3CreatePrismaticJoint(world, &def)
            }
        }
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
