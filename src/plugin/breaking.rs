//! The phases in which bodies break, as systems.

use crate::bodies::store::Bodies;
use crate::contact::impulses::ContactCache;
use crate::ecs::components::*;
use crate::ecs::state::PluginState;
use crate::ecs::{bond, cut};
use crate::fracture::{Bonds, Fractures};
use crate::joints::Joints;
use crate::step;
use crate::step::{Contacts, StepReport};
use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;

/// What bodies that break leave traces in.
#[derive(SystemParam)]
pub(super) struct Breaking<'w> {
    cache: ResMut<'w, ContactCache>,
    fractures: ResMut<'w, Fractures>,
    bonds: ResMut<'w, Bonds>,
    joints: ResMut<'w, Joints>,
}

impl Breaking<'_> {
    fn all(&mut self) -> step::Breakable<'_> {
        step::Breakable {
            cache: &mut self.cache,
            fractures: &mut self.fractures,
            bonds: &mut self.bonds,
            joints: &mut self.joints,
        }
    }
}

pub(super) fn cut(
    mut bodies: ResMut<Bodies>,
    mut breaking: Breaking,
    mut state: ResMut<PluginState>,
    mut warnings: ResMut<Messages<BodyWarning>>,
    handles: Query<&BodyHandle>,
) {
    let Breaking {
        cache,
        fractures,
        bonds,
        joints,
    } = &mut breaking;
    let PluginState {
        settings,
        slice_requests,
        ..
    } = &mut *state;
    cut::gather_requests(slice_requests, &bodies, fractures, &mut warnings, &handles);
    step::cut(&mut bodies, cache, fractures, bonds, settings);
    step::begin_joints(&mut bodies, fractures, joints);
}

pub(super) fn fracture(
    mut bodies: ResMut<Bodies>,
    mut contacts: ResMut<Contacts>,
    mut breaking: Breaking,
    state: Res<PluginState>,
    mut report: ResMut<StepReport>,
    mut broken: MessageWriter<BondBroken>,
) {
    step::fracture(
        &mut bodies,
        &mut contacts,
        breaking.all(),
        &state.settings,
        &mut report,
    );
    if !contacts.any_island_waits() {
        bond::report_broken(&breaking.bonds, &state.entities, &mut broken);
    }
}

/// Run condition of [`local_steps`]: most scenes have nothing that is small for the step.
pub(super) fn any_island_waits(contacts: Res<Contacts>) -> bool {
    contacts.any_island_waits()
}

pub(super) fn local_steps(
    mut bodies: ResMut<Bodies>,
    mut contacts: ResMut<Contacts>,
    mut breaking: Breaking,
    state: Res<PluginState>,
    mut report: ResMut<StepReport>,
    mut broken: MessageWriter<BondBroken>,
) {
    step::local_steps(
        &mut bodies,
        &mut contacts,
        breaking.all(),
        &state.settings,
        &mut report,
    );
    bond::report_broken(&breaking.bonds, &state.entities, &mut broken);
}
