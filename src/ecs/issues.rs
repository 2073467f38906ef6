//! What is wrong with entities: a component on each, for as long as it lasts, and a message when it begins.

use crate::bodies::body::BodyError;
use crate::ecs::components::{BodyProblem, BodyWarning, warn};
use bevy_ecs::entity::EntityHashMap;
use bevy_ecs::prelude::*;
use std::any::TypeId;

/// What is wrong with this entity's body. Written by the plugin, and taken off when all of it is mended.
///
/// What a command asked for and did not get (a cut, a bond) is told by [`BodyWarning`] alone.
#[derive(Clone, Debug, PartialEq, Component)]
#[component(clone_behavior = Ignore)]
pub struct BodyIssues(pub(super) Vec<BodyProblem>);

impl BodyIssues {
    /// The problems, in the order in which they were found.
    pub fn iter(&self) -> impl Iterator<Item = &BodyProblem> {
        self.0.iter()
    }
}

/// What a problem was found in: the next look at the same that finds nothing wrong mends it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Source {
    /// The entity as a whole, which is no body yet.
    Body,
    /// Shape, mass and materials.
    Description,
    /// Materials of a part of a compound.
    PartMaterial,
    /// What its shape is to be made from: the component of that type.
    Constructor(TypeId),
    /// How it moves.
    Kind,
    /// Pose and velocity.
    Motion,
    /// A velocity that does nothing.
    Velocity,
    /// Events and drives.
    Options,
    /// How it breaks.
    Breaking,
    /// Where it holds on to the world.
    Anchors,
    /// How blows wear it out.
    Fatigue,
    /// How it walks.
    Walker,
}

/// Something that is wrong with an entity.
#[derive(Clone, Debug)]
struct Issue {
    source: Source,
    problem: BodyProblem,
}

/// All that is wrong now.
#[derive(Clone, Debug, Default)]
pub(crate) struct Issues {
    /// By entity, in the order in which they were found. Entities of which nothing is wrong are not in it.
    known: EntityHashMap<Vec<Issue>>,
    /// Entities whose component is out of date.
    pub(super) changed: Vec<Entity>,
}

impl Issues {
    /// Takes note of a problem, and tells of it unless it is known.
    pub(crate) fn raise(
        &mut self,
        warnings: &mut Messages<BodyWarning>,
        entity: Entity,
        source: Source,
        problem: impl Into<BodyProblem>,
    ) {
        let problem = problem.into();
        let of_entity = self.known.entry(entity).or_default();
        let known = of_entity.iter_mut().find(|issue| issue.source == source);
        // As texts, because a NaN in the reason is not equal to itself.
        if (known.as_ref()).is_some_and(|known| known.problem.to_string() == problem.to_string()) {
            return;
        }
        warn(warnings, entity, problem.clone());
        self.changed.push(entity);
        match known {
            Some(known) => known.problem = problem,
            None => of_entity.push(Issue { source, problem }),
        }
    }

    /// Takes note that nothing is wrong with that any more.
    pub(crate) fn mend(&mut self, entity: Entity, source: Source) {
        self.mend_all(entity, |found| found == source);
    }

    /// Takes note that the entity is no body: nothing can be wrong with one.
    pub(crate) fn mend_body(&mut self, entity: Entity) {
        use Source::{Constructor, PartMaterial, Walker};
        self.mend_all(entity, |found| {
            !matches!(found, Constructor(_) | PartMaterial | Walker)
        });
    }

    /// Takes note that the entity has another body, of which nothing is wrong but what is found from now on.
    pub(crate) fn begin_body(&mut self, entity: Entity) {
        self.mend_all(entity, |found| {
            matches!(found, Source::Description | Source::Kind | Source::Motion)
        });
    }

    fn mend_all(&mut self, entity: Entity, is_mended: impl Fn(Source) -> bool) {
        let Some(of_entity) = self.known.get_mut(&entity) else {
            return;
        };
        let count = of_entity.len();
        of_entity.retain(|issue| !is_mended(issue.source));
        if of_entity.len() < count {
            self.changed.push(entity);
        }
        if of_entity.is_empty() {
            self.known.remove(&entity);
        }
    }

    /// Whether the entity could not be described for a reason that another `Transform` or parent may mend.
    pub(crate) fn is_any_of_place(&self, entity: Entity) -> bool {
        use BodyError::{Incomplete, Scaled, Sheared};
        self.of(entity).iter().any(|issue| {
            let is_of_place = matches!(
                issue.problem,
                BodyProblem::Body(Incomplete | Scaled(_) | Sheared)
            );
            issue.source == Source::Description && is_of_place
        })
    }

    /// Whether anything is wrong with the entity.
    pub(crate) fn is_any_of(&self, entity: Entity) -> bool {
        self.known.contains_key(&entity)
    }

    /// What is wrong with the entity, in the order in which it was found.
    pub(super) fn problems(&self, entity: Entity) -> Vec<BodyProblem> {
        let of_entity = self.of(entity).iter();
        of_entity.map(|issue| issue.problem.clone()).collect()
    }

    /// Forgets entities that are gone.
    pub(super) fn retain(&mut self, mut is_there: impl FnMut(Entity) -> bool) {
        self.known.retain(|&entity, _| is_there(entity));
    }

    fn of(&self, entity: Entity) -> &[Issue] {
        self.known.get(&entity).map_or(&[], Vec::as_slice)
    }

    /// Takes note of what a look found.
    pub(crate) fn note<T, E: Into<BodyProblem>>(
        &mut self,
        warnings: &mut Messages<BodyWarning>,
        entity: Entity,
        source: Source,
        found: Result<T, E>,
    ) -> Option<T> {
        match found {
            Ok(value) => {
                self.mend(entity, source);
                Some(value)
            }
            Err(problem) => {
                self.raise(warnings, entity, source, problem);
                None
            }
        }
    }
}
