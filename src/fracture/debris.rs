//! Pieces that lie around: which of them go again, when, and what goes with them.

use crate::bodies::body::RigidBody;
use crate::bodies::store::Bodies;
use crate::contact::body_id::BodyId;
use crate::contact::impulses::ContactCache;
use smallvec::SmallVec;

/// Most pieces that begin to go in one step, so that no step has much more to tidy up than those around it.
const MAX_LEAVING: usize = 32;

/// When pieces go again. By default they stay for ever, and nobody looks at them.
///
/// Debris is what a body broke into: dynamic pieces up to a size. What stands, because it holds on to the world, is none.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "reflect", derive(bevy_reflect::Reflect))]
pub struct DebrisRules {
    /// Most pieces of debris that there may be: those that came to be first go when there are more.
    pub max_pieces: usize,
    /// Time after which a piece goes, s. Infinite: never.
    pub max_age: f32,
    /// Time asleep after which a piece goes, s. Infinite: never. Nothing sleeps unless
    /// [`SleepConfig`](crate::solver::config::SleepConfig) says so.
    pub max_sleep: f32,
    /// Pieces smaller than this are dust, m3, and go as soon as they sleep.
    pub dust_volume: f32,
    /// Pieces larger than this are no debris, m3, and stay.
    pub max_volume: f32,
    /// Time between the moment at which a piece is to go and the one at which it is removed, s, for it to fade out.
    pub fade: f32,
}

impl Default for DebrisRules {
    fn default() -> Self {
        Self {
            max_pieces: usize::MAX,
            max_age: f32::INFINITY,
            max_sleep: f32::INFINITY,
            dust_volume: 0.0,
            max_volume: f32::INFINITY,
            fade: 0.0,
        }
    }
}

impl DebrisRules {
    /// Whether any piece may go.
    fn is_on(&self) -> bool {
        let Self {
            max_pieces,
            max_age,
            max_sleep,
            dust_volume,
            ..
        } = *self;
        max_pieces < usize::MAX || max_age.min(max_sleep) < f32::INFINITY || dust_volume > 0.0
    }

    /// Whether the time of a piece is over.
    fn is_over(&self, piece: &Alive, age: f64) -> bool {
        let is_dust = piece.volume < self.dust_volume && piece.slept > 0.0;
        is_dust || age > f64::from(self.max_age) || piece.slept > self.max_sleep
    }
}

/// A piece that was removed because its time was over.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExpiredPiece {
    /// The slot it had.
    pub slot: u32,
    /// Its id.
    pub body: BodyId,
    /// What went with it, kg.
    pub mass: f32,
}

/// A piece that will be removed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FadingPiece {
    /// Its slot.
    pub slot: u32,
    /// Its id.
    pub body: BodyId,
    /// Until then, s.
    pub remaining: f32,
}

/// What has been removed since the beginning: together with the bodies that are there and what the ledgers of fractures dropped,
/// it adds up to what there was.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RemovedDebris {
    /// Number of pieces.
    pub pieces: u64,
    /// kg.
    pub mass: f64,
}

/// A piece, and what its time is measured by.
#[derive(Clone, Copy, Debug)]
struct Alive {
    body: BodyId,
    slot: u32,
    /// m3.
    volume: f32,
    /// On the clock of [`Debris`], s.
    born: f64,
    /// s.
    slept: f32,
    /// Until it is removed, once it is to go, s.
    remaining: Option<f32>,
}

/// All pieces that are bodies, in the order in which they came to be.
#[derive(Clone, Debug, Default)]
pub(super) struct Debris {
    alive: Vec<Alive>,
    /// Time that has passed while there were rules, s.
    clock: f64,
}

impl Debris {
    /// Number of pieces.
    pub(super) fn len(&self) -> usize {
        self.alive.len()
    }

    /// Takes note of new pieces.
    pub(super) fn add(&mut self, bodies: &Bodies, pieces: &SmallVec<[u32; 8]>) {
        let born = self.clock;
        let volume = |slot: u32| bodies.info(slot).shape.hull_volume().unwrap_or(0.0);
        self.alive.extend(pieces.iter().map(|&slot| Alive {
            body: bodies.id(slot),
            slot,
            volume: volume(slot) as f32,
            born,
            slept: 0.0,
            remaining: None,
        }));
    }

    /// Forgets pieces that are no more, for whatever reason.
    pub(super) fn take_stock(&mut self, bodies: &Bodies) {
        self.alive
            .retain(|piece| bodies.is_current(piece.slot, piece.body));
    }

    /// Finds the pieces whose time is over after another `step_dt` seconds, and those that fade.
    pub(super) fn pass(
        &mut self,
        bodies: &Bodies,
        rules: &DebrisRules,
        step_dt: f32,
        (expired, fading): (&mut Vec<ExpiredPiece>, &mut Vec<FadingPiece>),
    ) {
        if !rules.is_on() {
            return;
        }
        self.clock += f64::from(step_dt);
        let clock = self.clock;
        let is_debris = |piece: &Alive| {
            let is_loose = bodies.kind(piece.slot) == RigidBody::Dynamic;
            is_loose && piece.volume <= rules.max_volume
        };
        self.take_stock(bodies);
        let stays = |piece: &&Alive| piece.remaining.is_none() && is_debris(piece);
        let count = if rules.max_pieces < usize::MAX {
            self.alive.iter().filter(stays).count()
        } else {
            0
        };
        let (mut too_many, mut leaving) = (count.saturating_sub(rules.max_pieces), 0);
        self.alive.retain_mut(|piece| {
            if !is_debris(piece) {
                return true;
            }
            let is_asleep = bodies.is_asleep(piece.slot);
            piece.slept = if is_asleep {
                piece.slept + step_dt
            } else {
                0.0
            };
            let remaining = match piece.remaining {
                Some(remaining) => remaining - step_dt,
                None if leaving == MAX_LEAVING => return true,
                None if too_many > 0 || rules.is_over(piece, clock - piece.born) => {
                    too_many = too_many.saturating_sub(1);
                    leaving += 1;
                    rules.fade
                }
                None => return true,
            };
            piece.remaining = Some(remaining);
            let Alive { slot, body, .. } = *piece;
            if remaining > 0.0 {
                fading.push(FadingPiece {
                    slot,
                    body,
                    remaining,
                });
                return true;
            }
            let mass = bodies.mass(slot).mass;
            expired.push(ExpiredPiece { slot, body, mass });
            false
        });
    }
}

impl RemovedDebris {
    /// Removes pieces from the bodies, and their multipliers.
    pub(super) fn remove(
        &mut self,
        expired: &mut [ExpiredPiece],
        bodies: &mut Bodies,
        cache: &mut ContactCache,
    ) {
        for piece in expired.iter() {
            bodies.remove(piece.slot);
            self.pieces += 1;
            self.mass += f64::from(piece.mass);
        }
        if !expired.is_empty() {
            expired.sort_unstable_by_key(|piece| piece.body);
            let find = |id| expired.binary_search_by_key(&id, |piece| piece.body);
            cache.remove_bodies(|id| find(id).is_ok());
        }
    }
}
