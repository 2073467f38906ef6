//! Jolt 5.0 through JoltC. Knob of `jolt`: velocity iterations in one collision step. Knob of `jolt-steps`:
//! collision steps, each with its own collision detection and the default iterations. Knob of `jolt-positions`: position iterations,
//! with as many velocity iterations and at least the default.

mod joints;

use crate::engine::{Engine, Entry, Settings, State};
use crate::scene::Scene;
use glam::{Quat, Vec3};
use joltc_sys::*;
use std::ffi::{c_uint, c_void};
use std::ptr::{null, null_mut};
use std::sync::Once;

// joltc-sys leaves out the C++ runtime.
#[cfg_attr(target_vendor = "apple", link(name = "c++"))]
#[cfg_attr(all(unix, not(target_vendor = "apple")), link(name = "stdc++"))]
unsafe extern "C" {}

struct Jolt {
    system: *mut JPC_PhysicsSystem,
    jobs: *mut JPC_JobSystemThreadPool,
    temp: *mut JPC_TempAllocatorImpl,
    layers: *mut JPC_BroadPhaseLayerInterface,
    broad_filter: *mut JPC_ObjectVsBroadPhaseLayerFilter,
    pair_filter: *mut JPC_ObjectLayerPairFilter,
    bodies: Vec<JPC_BodyID>,
    /// Scene to Jolt rotation: JoltC cannot change the direction of gravity, so the world is turned instead.
    frame: Quat,
    dt: f32,
    steps: i32,
}

pub(crate) fn entries() -> [Entry; 3] {
    let iterations =
        |scene: &Scene, settings: &Settings| build(scene, settings, [settings.value, 0], 1);
    let steps =
        |scene: &Scene, settings: &Settings| build(scene, settings, [0, 0], settings.value as i32);
    let positions = |scene: &Scene, settings: &Settings| {
        build(scene, settings, [settings.value.max(10), settings.value], 1)
    };
    [
        Entry::numbered(
            "jolt",
            "velocity_iterations",
            10,
            &[2, 5, 10, 20, 40],
            iterations,
        ),
        Entry::numbered("jolt-steps", "collision_steps", 1, &[1, 2, 4, 8], steps),
        Entry::numbered(
            "jolt-positions",
            "position_iterations",
            2,
            &[2, 5, 10, 20, 40],
            positions,
        )
        .for_joints(),
    ]
}

fn v(p: Vec3) -> JPC_Vec3 {
    JPC_Vec3 {
        x: p.x,
        y: p.y,
        z: p.z,
        _w: p.z,
    }
}

fn vec(p: JPC_Vec3) -> Vec3 {
    Vec3::new(p.x, p.y, p.z)
}

/// `iterations`: of velocities and of positions; 0: as Jolt has it.
fn build(scene: &Scene, settings: &Settings, iterations: [u32; 2], steps: i32) -> Box<dyn Engine> {
    static INIT: Once = Once::new();
    let g = scene.gravity;
    let level = g.x == 0.0 && g.z == 0.0;
    let frame = if level {
        Quat::IDENTITY
    } else {
        Quat::from_rotation_arc(g.normalize(), -Vec3::Y)
    };
    // SAFETY: the calls follow JoltC's own start-up order; everything is freed in `drop`.
    unsafe {
        INIT.call_once(|| {
            JPC_RegisterDefaultAllocator();
            JPC_FactoryInit();
            JPC_RegisterTypes();
        });
        let n = scene.bodies.len() as u32;
        let mut jolt = Jolt {
            system: JPC_PhysicsSystem_new(),
            // The calling thread works too.
            jobs: JPC_JobSystemThreadPool_new3(
                JPC_MAX_PHYSICS_JOBS as _,
                JPC_MAX_PHYSICS_BARRIERS as _,
                settings.threads as i32 - 1,
            ),
            temp: JPC_TempAllocatorImpl_new(256 << 20),
            layers: JPC_BroadPhaseLayerInterface_new(null(), LAYERS),
            broad_filter: JPC_ObjectVsBroadPhaseLayerFilter_new(null_mut(), BROAD_FILTER),
            pair_filter: JPC_ObjectLayerPairFilter_new(null_mut(), PAIR_FILTER),
            bodies: Vec::new(),
            frame,
            dt: scene.dt,
            steps,
        };
        let (pairs, contacts) = ((n * 32).max(4096), (n * 16).max(4096));
        JPC_PhysicsSystem_Init(
            jolt.system,
            n + 1,
            0,
            pairs,
            contacts,
            jolt.layers,
            jolt.broad_filter,
            jolt.pair_filter,
        );
        let interface = JPC_PhysicsSystem_GetBodyInterface(jolt.system);
        for b in &scene.bodies {
            let shape = &scene.shapes[b.shape];
            let (mut out, mut err) = (null_mut(), null_mut());
            let ok = if let Some(h) = shape.half_extents {
                // The default convex radius of 5 cm must not exceed the box.
                let radius = JPC_BoxShapeSettings::default()
                    .ConvexRadius
                    .min(0.5 * h.min_element());
                let def = JPC_BoxShapeSettings {
                    HalfExtent: v(h),
                    Density: b.density,
                    ConvexRadius: radius,
                    ..Default::default()
                };
                JPC_BoxShapeSettings_Create(&def, &mut out, &mut err)
            } else {
                let points: Vec<_> = shape.points.iter().map(|&p| v(p)).collect();
                let def = JPC_ConvexHullShapeSettings {
                    Points: points.as_ptr(),
                    PointsLen: points.len() as _,
                    Density: b.density,
                    ..Default::default()
                };
                JPC_ConvexHullShapeSettings_Create(&def, &mut out, &mut err)
            };
            assert!(ok, "shape");
            let (pos, rot) = (frame * b.pos, frame * b.rot);
            let def = JPC_BodyCreationSettings {
                Position: JPC_RVec3 {
                    x: pos.x,
                    y: pos.y,
                    z: pos.z,
                    _w: pos.z,
                },
                Rotation: JPC_Quat {
                    x: rot.x,
                    y: rot.y,
                    z: rot.z,
                    w: rot.w,
                },
                LinearVelocity: v(frame * b.linvel),
                AngularVelocity: v(frame * b.angvel),
                GravityFactor: g.length() / 9.81,
                ObjectLayer: !b.fixed as u16,
                MotionType: if b.fixed {
                    JPC_MOTION_TYPE_STATIC
                } else {
                    JPC_MOTION_TYPE_DYNAMIC
                },
                MotionQuality: if b.bullet {
                    JPC_MOTION_QUALITY_LINEAR_CAST
                } else {
                    JPC_MOTION_QUALITY_DISCRETE
                },
                AllowSleeping: settings.sleeping,
                // The other engines have no damping and do have gyroscopic torque.
                ApplyGyroscopicForce: true,
                LinearDamping: 0.0,
                AngularDamping: 0.0,
                Friction: scene.friction,
                Restitution: scene.restitution,
                NumVelocityStepsOverride: iterations[0],
                NumPositionStepsOverride: iterations[1],
                Shape: out,
                ..Default::default()
            };
            let mode = if b.fixed {
                JPC_ACTIVATION_DONT_ACTIVATE
            } else {
                JPC_ACTIVATION_ACTIVATE
            };
            jolt.bodies
                .push(JPC_BodyInterface_CreateAndAddBody(interface, &def, mode));
        }
        joints::add(jolt.system, scene, &jolt.bodies, iterations);
        JPC_PhysicsSystem_OptimizeBroadPhase(jolt.system);
        Box::new(jolt)
    }
}

impl Engine for Jolt {
    fn step(&mut self) {
        // SAFETY: all pointers live as long as `self`.
        let err = unsafe {
            JPC_PhysicsSystem_Update(self.system, self.dt, self.steps, self.temp, self.jobs)
        };
        assert!(
            err == JPC_PHYSICS_UPDATE_ERROR_NONE,
            "Jolt ran out of a fixed buffer"
        );
    }

    fn read(&self, out: &mut Vec<State>) {
        let back = self.frame.inverse();
        out.extend(self.bodies.iter().map(|&id| {
            // SAFETY: the system and its bodies are alive.
            let (p, q, l, a) = unsafe {
                let interface = JPC_PhysicsSystem_GetBodyInterface(self.system);
                (
                    JPC_BodyInterface_GetCenterOfMassPosition(interface, id),
                    JPC_BodyInterface_GetRotation(interface, id),
                    JPC_BodyInterface_GetLinearVelocity(interface, id),
                    JPC_BodyInterface_GetAngularVelocity(interface, id),
                )
            };
            State {
                pos: back * Vec3::new(p.x, p.y, p.z),
                rot: back * Quat::from_xyzw(q.x, q.y, q.z, q.w),
                linvel: back * vec(l),
                angvel: back * vec(a),
            }
        }));
    }

    fn num_awake(&self) -> Option<usize> {
        // SAFETY: the system and its bodies are alive.
        let active = |&&id: &&JPC_BodyID| unsafe {
            JPC_BodyInterface_IsActive(JPC_PhysicsSystem_GetBodyInterface(self.system), id)
        };
        Some(self.bodies.iter().filter(active).count())
    }
}

impl Drop for Jolt {
    fn drop(&mut self) {
        // SAFETY: each object was made in `build` and is freed once, users before what they use.
        unsafe {
            JPC_PhysicsSystem_delete(self.system);
            JPC_BroadPhaseLayerInterface_delete(self.layers);
            JPC_ObjectVsBroadPhaseLayerFilter_delete(self.broad_filter);
            JPC_ObjectLayerPairFilter_delete(self.pair_filter);
            JPC_JobSystemThreadPool_delete(self.jobs);
            JPC_TempAllocatorImpl_delete(self.temp);
        }
    }
}

/// Two layers: 0 fixed, 1 moving. Fixed bodies do not meet each other.
const LAYERS: JPC_BroadPhaseLayerInterfaceFns = {
    unsafe extern "C" fn count(_: *const c_void) -> c_uint {
        2
    }
    unsafe extern "C" fn layer(_: *const c_void, layer: JPC_ObjectLayer) -> JPC_BroadPhaseLayer {
        layer as JPC_BroadPhaseLayer
    }
    JPC_BroadPhaseLayerInterfaceFns {
        GetNumBroadPhaseLayers: Some(count as _),
        GetBroadPhaseLayer: Some(layer as _),
    }
};

const BROAD_FILTER: JPC_ObjectVsBroadPhaseLayerFilterFns = {
    unsafe extern "C" fn test(
        _: *const c_void,
        a: JPC_ObjectLayer,
        b: JPC_BroadPhaseLayer,
    ) -> bool {
        a != 0 || b != 0
    }
    JPC_ObjectVsBroadPhaseLayerFilterFns {
        ShouldCollide: Some(test as _),
    }
};

const PAIR_FILTER: JPC_ObjectLayerPairFilterFns = {
    unsafe extern "C" fn test(_: *const c_void, a: JPC_ObjectLayer, b: JPC_ObjectLayer) -> bool {
        a != 0 || b != 0
    }
    JPC_ObjectLayerPairFilterFns {
        ShouldCollide: Some(test as _),
    }
};
