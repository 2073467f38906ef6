//! Whatever is done to entities: they and their bodies know each other, what is told of contacts and pieces comes out even, and of
//! what goes nothing is left.

use crate::random_world::{Deed, RandomWorld};
use crate::twins::{alive, body_of, check, texts};
use bevy_app::FixedPostUpdate;
use bevy_cleave::prelude::*;
use bevy_ecs::entity_disabling::Disabled;
use bevy_ecs::prelude::*;
use bevy_ecs::query::Allow;
use bevy_transform::components::Transform;
use std::collections::HashSet;

/// What was told since the last look.
#[derive(Resource, Default)]
struct Heard {
    /// Ends and starts of contacts, in that order within a step.
    contacts: Vec<(bool, Entity, Entity)>,
    broken: Vec<Fractured>,
}

fn listen(
    mut starts: MessageReader<CollisionStart>,
    mut ends: MessageReader<CollisionEnd>,
    mut broken: MessageReader<Fractured>,
    mut heard: ResMut<Heard>,
) {
    let ends = ends.read().map(|end| (false, end.entity, end.other));
    heard.contacts.extend(ends);
    let starts = starts.read().map(|start| (true, start.entity, start.other));
    heard.contacts.extend(starts);
    heard.broken.extend(broken.read().cloned());
}

/// Who touches whom and which pieces there are, by what was told.
struct Accounts {
    scene: RandomWorld,
    open: HashSet<(Entity, Entity)>,
    pieces: HashSet<Entity>,
}

impl Accounts {
    fn new() -> Self {
        let mut scene = RandomWorld::new(true);
        scene.app.init_resource::<Heard>();
        scene.app.add_systems(FixedPostUpdate, listen);
        Self {
            scene,
            open: HashSet::new(),
            pieces: HashSet::new(),
        }
    }

    fn run(&mut self, deed: Deed) -> Result<(), String> {
        self.scene.run(deed);
        let Deed::Frame(steps) = deed else {
            return Ok(());
        };
        let heard = std::mem::take(&mut *self.scene.app.world_mut().resource_mut::<Heard>());
        self.hear(&heard.contacts)?;
        self.count_pieces(&heard.broken, steps)?;
        if steps > 0 {
            self.look()?;
        }
        Ok(())
    }

    /// Each pair begins and ends in turns.
    fn hear(&mut self, contacts: &[(bool, Entity, Entity)]) -> Result<(), String> {
        let unsure = &self.scene.unsure;
        let is_sure = |(a, b): &(Entity, Entity)| !unsure.contains(a) && !unsure.contains(b);
        self.open.retain(is_sure);
        for &(begins, a, b) in contacts.iter().filter(|(_, a, b)| is_sure(&(*a, *b))) {
            let pair = (a.min(b), a.max(b));
            let is_news = match begins {
                true => self.open.insert(pair),
                false => self.open.remove(&pair),
            };
            if !is_news {
                return Err(format!("{pair:?} begins ({begins}) or ends twice"));
            }
        }
        Ok(())
    }

    /// Each piece is told of once, is related to what it was, and has its share of the mass.
    fn count_pieces(&mut self, told: &[Fractured], steps: u32) -> Result<(), String> {
        let (world, cloned) = (self.scene.app.world_mut(), &self.scene.cloned);
        for fractured in told {
            let ledger = &fractured.ledger;
            let mut sum = ledger.after.mass;
            for &piece in &fractured.pieces {
                if !self.pieces.insert(piece) {
                    return Err(format!("{piece} is told of twice"));
                }
                if let Ok(it) = world.get_entity(piece) {
                    if !it.contains::<PieceOf>() {
                        return Err(format!("{piece} is a piece of nothing"));
                    }
                    let mass = it.get::<MassProperties>().map_or(0.0, |it| it.mass);
                    sum -= f64::from(mass);
                }
            }
            let lives = world.get_entity(fractured.parent).is_ok();
            if lives != fractured.goes_on {
                return Err(format!("{} lives on: {lives}", fractured.parent));
            }
            // In another step they may have broken again. Masses are `f32`.
            let off = sum.abs() / ledger.before.mass;
            if steps == 1 && !lives && (ledger.mass_error() > 1e-6 || off > 1e-5) {
                return Err(format!("{off:e} of the mass is off: {ledger:?}"));
            }
        }
        let mut pieces = world.query_filtered::<Entity, (With<PieceOf>, Allow<Disabled>)>();
        let known = |piece: &Entity| self.pieces.contains(piece) || cloned.contains(piece);
        match pieces.iter(world).find(|piece| !known(piece)) {
            Some(piece) => Err(format!("nobody was told of the piece {piece}")),
            None => Ok(()),
        }
    }

    /// Bodies and entities know each other, and what is unusable says so.
    fn look(&self) -> Result<(), String> {
        let world = self.scene.app.world();
        let bodies = world.resource::<Bodies>();
        let mut known = HashSet::new();
        for entity in alive(&self.scene) {
            known.extend(look_at(world, entity).map_err(|error| format!("{entity} {error}"))?);
        }
        if known.len() != bodies.len() {
            return Err(format!(
                "{} bodies of {} entities",
                bodies.len(),
                known.len()
            ));
        }
        let joints = world.resource::<Joints>();
        let joined = joints
            .iter()
            .flat_map(|id| joints.bodies(id).into_iter().flatten());
        let bonded = world.resource::<Bonds>().iter().flat_map(|(pair, _)| pair);
        if !joined
            .flatten()
            .chain(bonded)
            .all(|slot| bodies.contains(slot))
        {
            return Err("a joint or bond of nobody".to_string());
        }
        for &it in self.open.iter().flat_map(|(a, b)| [a, b]) {
            if !body_of(world, it).is_some_and(|slot| bodies.is_active(slot)) {
                return Err(format!("{it} touches and takes no part"));
            }
        }
        Ok(())
    }

    /// Everything goes; what is left.
    fn close(mut self) -> Result<(), String> {
        self.run(Deed::Frame(1))?;
        for entity in alive(&self.scene) {
            // Some go with others.
            if let Ok(entity) = self.scene.app.world_mut().get_entity_mut(entity) {
                entity.despawn();
            }
        }
        (0..12).try_for_each(|_| self.run(Deed::Frame(1)))?;
        let world = self.scene.app.world_mut();
        let mut marked =
            world.query_filtered::<(), Or<(With<BodyIssues>, With<Pieces>, With<Remains>)>>();
        let left = [
            self.open.len(),
            marked.iter(world).count(),
            world.resource::<Bodies>().len(),
            world.resource::<Joints>().len(),
            world.resource::<Bonds>().len(),
            world.resource::<ContactCache>().len(),
        ];
        if left != [0; 6] {
            return Err(format!("left behind: {left:?}, {:?}", self.open));
        }
        Ok(())
    }
}

/// The slot of an entity's body, if it has one.
fn look_at(world: &World, entity: Entity) -> Result<Option<u32>, &'static str> {
    let bodies = world.resource::<Bodies>();
    let it = world.entity(entity);
    let is_body = it.contains::<RigidBody>();
    let is_on = !it.contains::<Disabled>();
    let is_silent = texts(world, entity).is_empty();
    let Some((slot, id)) = it.get::<BodyHandle>().and_then(BodyHandle::get) else {
        if is_body && is_on && is_silent && !it.contains::<ShapeAwaited>() {
            return Err("has no body and says nothing");
        }
        return Ok(None);
    };
    let transform = it.get::<Transform>().copied().unwrap_or_default();
    let (v, omega) = bodies.velocity(slot);
    let is_finite = v.is_finite() && omega.is_finite() && bodies.pose(slot).is_finite();
    let lies = [
        (!is_body, "is no body and has one"),
        (!bodies.is_current(slot, id), "has a body that is gone"),
        (
            !is_on && bodies.is_active(slot),
            "is disabled and takes part",
        ),
        (
            is_on && !bodies.is_active(slot) && is_silent,
            "takes no part and says nothing",
        ),
        (!is_finite, "has a body without numbers"),
        (
            is_on && is_silent && !transform.is_finite(),
            "has no numbers and says nothing",
        ),
        (
            is_on && is_silent && it.get() != Some(&bodies.kind(slot)),
            "moves otherwise than it says",
        ),
        (
            is_on && it.contains::<Sleeping>() != bodies.is_asleep(slot),
            "has the wrong mark of sleep",
        ),
    ];
    match lies.into_iter().find(|(is_so, _)| *is_so) {
        Some((_, lie)) => Err(lie),
        None => Ok(Some(slot)),
    }
}

fn accounts_come_out_even(deeds: &[Deed]) -> Result<(), String> {
    let mut accounts = Accounts::new();
    let is_long = deeds
        .last()
        .is_some_and(|deed| matches!(deed, Deed::Act(_)));
    for &deed in deeds {
        accounts.run(deed)?;
        if is_long && deed == Deed::Frame(5) {
            // Some fall asleep.
            (0..40).try_for_each(|_| accounts.run(Deed::Frame(1)))?;
        }
    }
    accounts.close()
}

#[test]
fn bodies_contacts_and_pieces_are_told_of_as_they_are_and_nothing_stays_behind() {
    check(accounts_come_out_even, 40, 0..180);
}
