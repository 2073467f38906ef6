//! Which bodies a question is about.

use crate::bodies::store::Bodies;
use crate::contact::layers::CollisionLayers;

/// Which bodies a question is about; by default all.
///
/// `Body` is what bodies are called: a slot (`u32`), or in an app an entity.
#[derive(Clone, Copy)]
pub struct QueryFilter<'f, Body = u32> {
    pub(crate) layers: Option<CollisionLayers>,
    pub(crate) excluded: &'f [Body],
    pub(crate) predicate: Option<&'f dyn Fn(Body) -> bool>,
}

impl<Body> Default for QueryFilter<'_, Body> {
    fn default() -> Self {
        Self {
            layers: None,
            excluded: &[],
            predicate: None,
        }
    }
}

impl<Body: std::fmt::Debug> std::fmt::Debug for QueryFilter<'_, Body> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("QueryFilter")
            .field("layers", &self.layers)
            .field("excluded", &self.excluded)
            .field("has_predicate", &self.predicate.is_some())
            .finish()
    }
}

impl<'f, Body> QueryFilter<'f, Body> {
    /// All bodies.
    pub fn all() -> Self {
        Self::default()
    }

    /// Only bodies that a body of these layers may touch.
    pub fn with_layers(self, layers: CollisionLayers) -> Self {
        Self {
            layers: Some(layers),
            ..self
        }
    }

    /// None of these.
    pub fn excluding(self, excluded: &'f [Body]) -> Self {
        Self { excluded, ..self }
    }

    /// Only bodies of which the predicate is true. It may be asked of a body more than once.
    pub fn with_predicate(self, predicate: &'f dyn Fn(Body) -> bool) -> Self {
        Self {
            predicate: Some(predicate),
            ..self
        }
    }
}

impl QueryFilter<'_> {
    /// Whether all bodies count.
    pub(crate) fn is_open(&self) -> bool {
        self.layers.is_none() && self.excluded.is_empty() && self.predicate.is_none()
    }

    /// Whether the body in `slot` counts.
    pub(crate) fn accepts(&self, bodies: &Bodies, slot: u32) -> bool {
        let layers = || bodies.info(slot).layers;
        self.layers.is_none_or(|own| own.interact(&layers()))
            && !self.excluded.contains(&slot)
            && self.predicate.is_none_or(|predicate| predicate(slot))
    }
}
