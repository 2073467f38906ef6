//! Flat arrays of what the step reads and writes, one entry per slot.
//!
//! A body keeps its slot for life; slots of removed bodies are reused. Everything that is ordered is ordered by
//! [`BodyId`], never by slot, so results do not depend on which slots were free.

pub(crate) use crate::bodies::body::{BodyDesc, BodyError, RigidBody};
use crate::bodies::local_state::LocalBodies;
use crate::bodies::pushes::Pushes;
use crate::bodies::sleep_state::Status;
use crate::bodies::solver_body::Motion;
use crate::bodies::solver_body::SolverBody;

use crate::bodies::anchors::Hold;
use crate::bodies::body::{BodyInfo, check_pose, check_velocity};
use crate::bodies::cluster_state::ClusterState;
use crate::bodies::drive::Drives;
use crate::bodies::fatigue::Wearing;
use crate::bodies::free_rotation::FreeRotation;
use crate::bodies::sleep_state::Sleep;
use crate::contact::body_id::BodyId;
use crate::geometry::{Compound, ConvexMesh, KdBox};
use crate::mass::MassProperties;
use crate::math::{Pose, rotate};
use bevy_ecs::resource::Resource;
use glam::{Mat3, Quat, Vec3};

/// All bodies of a simulation.
///
/// A slot is an index: methods that take one panic if it was never given out, and those that need a body panic if there
/// is none in it any more; [`contains`](Self::contains) tells.
#[derive(Clone, Debug, Default, Resource)]
pub struct Bodies {
    pub(crate) ids: Vec<BodyId>,
    pub(crate) status: Vec<Status>,
    pub(crate) info: Vec<Option<BodyInfo>>,
    /// Position of the center of mass, world, m.
    pub(crate) center: Vec<Vec3>,
    /// `world_from_body` rotation.
    pub(crate) rotation: Vec<Quat>,
    pub(crate) velocity: Vec<SolverBody>,
    /// Where the solver has moved the bodies that take part and are not static.
    pub(crate) motion: Vec<Motion>,
    pub(crate) mass: Vec<MassProperties>,
    /// Inverse inertia tensor about the center of mass, world axes, 1/(kg m2).
    pub(crate) inverse_inertia: Vec<Mat3>,
    pub(crate) kd_box: Vec<Option<KdBox>>,
    /// Least extent of the hull's box, of several the least, m: what slop and contact margin are relative to.
    pub(crate) min_extent: Vec<f32>,
    /// Largest distance of the hull from the center of mass, m; 0 for half-spaces, and until the mass phase has seen the shape.
    pub(super) radius: Vec<f32>,
    /// Changes with shape, mass or material: what is kept about the body elsewhere is out of date then.
    pub(crate) version: Vec<u32>,
    /// Impulse of a blow that the body bears whatever its strength, N s: of a larger one nothing came. Infinite while it waits for
    /// its turn to break.
    pub(crate) borne_impulse: Vec<f32>,
    /// Slots whose mass properties are out of date.
    pub(crate) stale_mass: Vec<u32>,
    /// Slots whose mass properties the last mass phase computed.
    pub(crate) fresh_mass: Vec<u32>,
    /// Number of bodies that can break.
    pub(super) fracturable: usize,
    /// Number of dynamic bodies.
    pub(super) dynamic: usize,
    /// Slots of bodies that only sense, in no order.
    pub(crate) sensors: Vec<u32>,
    /// What moves bodies besides gravity and contacts, or keeps them from moving.
    pub(crate) drives: Drives,
    /// By slot, as far as any has it: how bodies that stand hold on to the world.
    pub(crate) holds: Vec<Option<Box<Hold>>>,
    /// By slot, as far as any is one: bodies whose parts are held by bonds.
    pub(crate) clusters: Vec<Option<Box<ClusterState>>>,
    /// Static ones of them of which it is not known yet which parts hold on to the world.
    pub(crate) unheld_clusters: Vec<u32>,
    /// Those that came as several groups of parts: copies of what waited to come apart.
    pub(crate) divided_clusters: Vec<(u32, BodyId)>,
    /// Those that have lost bonds since the entities were last told, and go on.
    pub(crate) cracked: Vec<(u32, BodyId)>,
    /// Blasts, and what acts at points of clusters, in the next step.
    pub(crate) pushes: Pushes,
    /// Those that blows wear out, by slot.
    pub(crate) wearing: Vec<Wearing>,
    /// Whether there was ever a body that is a level of triangles.
    pub(crate) any_level: bool,
    /// Whether there was ever a round one.
    pub(crate) any_round: bool,
    /// Whether there was ever one of several parts.
    pub(crate) any_compound: bool,
    /// Who rests, and what was changed since.
    pub(crate) sleep: Sleep,
    /// Who takes local steps while all others wait.
    pub(crate) local: LocalBodies,
    /// Pairs of bodies that are bonded, ascending: their contact stays where the bond was made, wherever they are going.
    pub(crate) bonded: Vec<(BodyId, BodyId)>,
    /// Pairs of bodies that do not touch each other because a joint says so, ascending.
    pub(crate) apart: Vec<(BodyId, BodyId)>,
    /// Bodies that joints hold, ascending: they do not turn as free ones do.
    pub(crate) jointed: Vec<BodyId>,
    pub(super) free: Vec<u32>,
    /// Slots that become free with the next step: something may name them until then.
    pub(super) retired: Vec<u32>,
    /// How often a body has gone, or was kept out of the scene: a slot that was noted before may not have its body any more.
    pub(crate) departures: u64,
    /// How often a velocity was set from outside of the step, or a body became one that moves by it.
    pub(crate) velocities_set: u64,
    pub(super) next_id: u32,
    pub(super) alive: usize,
}

impl Bodies {
    /// Number of bodies.
    pub fn len(&self) -> usize {
        self.alive
    }

    /// Whether there are no bodies.
    pub fn is_empty(&self) -> bool {
        self.alive == 0
    }

    /// Number of slots, used or free.
    pub fn slots(&self) -> usize {
        self.ids.len()
    }

    /// Adds a body and returns its slot. Its mass is computed by the next mass phase.
    ///
    /// # Errors
    /// [`BodyError`] for a state, density or material that is not usable; nothing is added then.
    pub fn insert(&mut self, desc: BodyDesc) -> Result<u32, BodyError> {
        check_pose(&desc.pose)?;
        check_velocity(desc.linear_velocity, desc.angular_velocity)?;
        let (pose, linear, angular) = (desc.pose, desc.linear_velocity, desc.angular_velocity);
        let info = BodyInfo::of(desc);
        info.check_material()?;
        info.check_mass()?;
        let slot = self.free.pop().unwrap_or_else(|| self.grow());
        let i = slot as usize;
        self.ids[i] = BodyId(self.next_id);
        self.next_id += 1;
        self.alive += 1;
        self.velocities_set += 1;
        self.status[i] = Status::Active;
        self.join_local(slot);
        self.center[i] = pose.position;
        self.rotation[i] = pose.rotation;
        self.velocity[i] = SolverBody {
            linear,
            angular,
            ..Default::default()
        };
        self.mass[i] = MassProperties::default();
        self.inverse_inertia[i] = Mat3::ZERO;
        self.borne_impulse[i] = 0.0;
        self.info[i] = Some(info);
        self.fracturable += usize::from(self.info(slot).fracturable.is_some());
        self.dynamic += usize::from(self.kind(slot) == RigidBody::Dynamic);
        self.note_sensor(slot);
        self.mark_shape_changed(slot);
        self.disturb(slot);
        Ok(slot)
    }

    /// Adds a body whose mass properties are needed at once: a piece of another body.
    pub(crate) fn insert_with_mass(&mut self, desc: BodyDesc) -> Result<u32, BodyError> {
        let slot = self.insert(desc)?;
        self.refresh_mass(slot).inspect_err(|_| self.remove(slot))?;
        self.stale_mass.pop();
        Ok(slot)
    }

    /// Slots that hold a body, ascending.
    pub fn iter(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.slots() as u32).filter(|&s| self.status[s as usize] != Status::Free)
    }

    /// Whether `slot` holds a body.
    pub fn contains(&self, slot: u32) -> bool {
        self.status
            .get(slot as usize)
            .is_some_and(|s| *s != Status::Free)
    }

    /// Whether the body takes part, that is, its state is finite.
    pub fn is_active(&self, slot: u32) -> bool {
        matches!(
            self.status.get(slot as usize),
            Some(Status::Active | Status::Asleep | Status::Local)
        )
    }

    /// Whether the body takes part, is awake and not static.
    pub(crate) fn is_moving(&self, slot: u32) -> bool {
        let status = self.status.get(slot as usize);
        matches!(status, Some(Status::Active | Status::Local)) && !self.is_static(slot)
    }

    /// Whether contacts may move the body: it is dynamic and takes part, awake.
    pub(crate) fn is_carried(&self, slot: u32) -> bool {
        self.velocity[slot as usize].inverse_mass > 0.0 && self.is_moving(slot)
    }

    /// Whether the body is static.
    pub(crate) fn is_static(&self, slot: u32) -> bool {
        // What contacts move is not; that spares most bodies a look at far memory.
        let is_moved = self.velocity[slot as usize].inverse_mass > 0.0;
        !is_moved && self.kind(slot) == RigidBody::Static
    }

    /// Number of dynamic bodies.
    pub(crate) fn dynamic(&self) -> usize {
        self.dynamic
    }

    /// The rotation of a dynamic body that must be followed within a step of `step` seconds.
    pub(crate) fn spin(&self, slot: u32, step: f32) -> Option<FreeRotation> {
        let i = slot as usize;
        let body = &self.velocity[i];
        if body.inverse_mass == 0.0 {
            return None;
        }
        if self.drives.has_locked_turns(slot) {
            return None;
        }
        FreeRotation::of(self.rotation[i], self.mass(slot), body.angular, step)
    }

    /// Id of the body in `slot`.
    pub fn id(&self, slot: u32) -> BodyId {
        self.ids[slot as usize]
    }

    /// How the body moves.
    pub fn kind(&self, slot: u32) -> RigidBody {
        self.info(slot).kind
    }

    /// The shape of the body, if it has several parts.
    pub fn compound(&self, slot: u32) -> Option<&Compound> {
        self.info.get(slot as usize)?.as_ref()?.shape.compound()
    }

    /// The convex shape of the body; `None` for other shapes or a free slot.
    pub fn convex(&self, slot: u32) -> Option<&ConvexMesh> {
        self.info.get(slot as usize)?.as_ref()?.shape.convex()
    }

    /// `world_from_body`: pose of the frame that the shape is given in.
    pub fn pose(&self, slot: u32) -> Pose {
        let i = slot as usize;
        Pose {
            position: self.center[i] - rotate(self.rotation[i], self.mass[i].center),
            rotation: self.rotation[i],
        }
    }

    /// World position of the center of mass, m.
    pub fn center_of_mass(&self, slot: u32) -> Vec3 {
        self.center[slot as usize]
    }

    /// Velocity of the center of mass (m/s) and angular velocity (rad/s), world axes.
    pub fn velocity(&self, slot: u32) -> (Vec3, Vec3) {
        let v = &self.velocity[slot as usize];
        (v.linear, v.angular)
    }

    /// Velocities and inverse masses of all slots: what a solver works on.
    #[doc(hidden)]
    pub fn solver_bodies(&self) -> &[SolverBody] {
        &self.velocity
    }

    /// Whether `slot` holds the body with this id, and not a later one.
    pub fn is_current(&self, slot: u32, id: BodyId) -> bool {
        self.contains(slot) && self.id(slot) == id
    }

    /// Puts the body's frame somewhere else, and wakes it and what rests on it, unless it is there already.
    ///
    /// # Errors
    /// [`BodyError`] if the pose is not finite or not a rotation; the body stays where it was then.
    pub fn set_pose(&mut self, slot: u32, pose: Pose) -> Result<(), BodyError> {
        check_pose(&pose)?;
        if pose != self.pose(slot) {
            self.disturb(slot);
        } else if self.is_asleep(slot) {
            return Ok(());
        }
        self.place(slot, pose);
        self.refresh_world(slot);
        Ok(())
    }

    /// Sets velocity of the center of mass (m/s) and angular velocity (rad/s), world axes. Static bodies stay at rest.
    /// A body that sleeps wakes, unless both are zero.
    ///
    /// # Errors
    /// [`BodyError::NotFinite`]; the velocity stays as it was then.
    pub fn set_velocity(
        &mut self,
        slot: u32,
        linear: Vec3,
        angular: Vec3,
    ) -> Result<(), BodyError> {
        check_velocity(linear, angular)?;
        if self.kind(slot) != RigidBody::Static {
            if self.is_asleep(slot) && (linear, angular) != (Vec3::ZERO, Vec3::ZERO) {
                self.wake(slot);
            }
            let v = &mut self.velocity[slot as usize];
            (v.linear, v.angular) = (linear, angular);
            self.velocities_set += 1;
        }
        Ok(())
    }

    /// Sets center of mass and rotation from the pose of the body's frame.
    pub(super) fn place(&mut self, slot: u32, pose: Pose) {
        let i = slot as usize;
        self.rotation[i] = pose.rotation;
        self.center[i] = pose.position + rotate(pose.rotation, self.mass[i].center);
    }

    /// Takes over shape, density, material, layers and strength from `desc`, but neither pose nor velocity nor kind. Wakes
    /// the body and what rests on it if that changes anything.
    ///
    /// # Errors
    /// [`BodyError`]; the body stays as it was then.
    pub fn redescribe(&mut self, slot: u32, desc: BodyDesc) -> Result<(), BodyError> {
        let info = BodyInfo {
            kind: self.kind(slot),
            cut_looks: self.info(slot).cut_looks.clone(),
            ..BodyInfo::of(desc)
        };
        info.check_material()?;
        let same_mass = info.has_mass_of(self.info(slot));
        if !same_mass {
            info.check_mass()?;
        }
        self.set_fracturable(slot, info.fracturable.clone());
        if same_mass && info.touches_like(self.info(slot)) {
            // What is known of its contacts stays true.
            return Ok(());
        }
        self.disturb(slot);
        self.info[slot as usize] = Some(info);
        self.note_sensor(slot);
        self.renew_version(slot);
        if !same_mass {
            self.mark_shape_changed(slot);
        }
        Ok(())
    }

    pub(crate) fn info(&self, slot: u32) -> &BodyInfo {
        self.info[slot as usize]
            .as_ref()
            .expect("slot holds a body")
    }

    /// Call after changing shape, density or mass override: boxes now, mass in the next mass phase.
    pub(crate) fn mark_shape_changed(&mut self, slot: u32) {
        let i = slot as usize;
        let shape = &self.info(slot).shape;
        let aabb = shape.solid_aabb();
        let compound = shape.compound();
        let extent = aabb.map_or(f32::INFINITY, |b| b.extents().min_element());
        let extent = compound.map_or(extent, Compound::min_extent);
        let (is_level, is_compound) = (shape.level().is_some(), compound.is_some());
        self.any_round |= shape.is_round();
        self.any_level |= is_level;
        self.any_compound |= is_compound;
        self.kd_box[i] = aabb.map(KdBox::around);
        self.min_extent[i] = extent;
        self.radius[i] = 0.0;
        self.stale_mass.push(slot);
        self.renew_version(slot);
    }

    /// Takes a body out of the simulation, or lets it in again.
    pub(crate) fn set_frozen(&mut self, slot: u32, frozen: bool) {
        debug_assert!(self.contains(slot), "no body to freeze");
        if frozen == (self.status[slot as usize] == Status::Frozen) {
            return;
        }
        self.departures += 1;
        self.disturb(slot);
        self.status[slot as usize] = if frozen {
            Status::Frozen
        } else {
            Status::Active
        };
    }

    pub(super) fn renew_version(&mut self, slot: u32) {
        let version = &mut self.version[slot as usize];
        *version = version.wrapping_add(1);
    }
}
