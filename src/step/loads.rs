//! The end of phase 6: what is borne for long.

use crate::bodies::store::Bodies;
use crate::fracture::{StepLoads, break_under_loads, end_loads};
use crate::step::breakable::Breakable;
use crate::step::contacts::Contacts;
use crate::step::settings::StepSettings;

/// When all is solved: bonds within bodies that sustained loads break, and the end of what blows were borne.
pub(super) fn bear_loads(
    bodies: &mut Bodies,
    contacts: &Contacts,
    breakable: Breakable,
    settings: &StepSettings,
) {
    let loads = StepLoads {
        manifolds: &contacts.manifolds,
        joints: breakable.joints,
        gravity: settings.gravity.0,
        step_dt: settings.step_dt,
    };
    break_under_loads(breakable.fractures, bodies, &loads);
    end_loads(breakable.fractures, bodies, &contacts.solver);
}
