//! What a step is measured by once it is solved.

use crate::bodies::store::Bodies;
use crate::solver::config::SolverConfig;
use crate::solver::rows::residual::ResidualSum;
use crate::step::contacts::Contacts;
use crate::step::report::{IslandReport, StepError, StepReport};
use crate::step::settings::StepSettings;

pub(crate) fn report_solution(
    bodies: &Bodies,
    contacts: &mut Contacts,
    settings: &StepSettings,
    report: &mut StepReport,
) {
    report_islands(contacts, &settings.config, report);
    let before = contacts.energy_before;
    report.error = before.map(|before| measure_error(bodies, contacts, settings, before));
}

fn report_islands(contacts: &mut Contacts, config: &SolverConfig, report: &mut StepReport) {
    let Contacts { solver, rows, .. } = contacts;
    report.islands.clear();
    report.unconverged.clear();
    for island in solver.islands() {
        let movable = island.bodies.iter().position(|b| b.inverse_mass > 0.0);
        let slot = island.slots[movable.unwrap_or(0)];
        if island.budget.is_unconverged {
            report.unconverged.push(slot);
        }
        if config.measure_islands {
            let residual = config
                .measure_error
                .then(|| island.residual_sum(rows).residual());
            report.islands.push(IslandReport {
                slot,
                bodies: island.bodies.len(),
                contacts: island.contacts,
                sweeps: island.budget.sweeps,
                is_unconverged: island.budget.is_unconverged,
                residual,
            });
        }
    }
}

fn measure_error(
    bodies: &Bodies,
    contacts: &mut Contacts,
    settings: &StepSettings,
    energy_before: f64,
) -> StepError {
    let Contacts {
        solver,
        rows,
        manifolds,
        ..
    } = contacts;
    let mut sum = ResidualSum::default();
    for island in solver.islands() {
        sum.add(&island.residual_sum(rows));
    }
    let [kinetic_energy, potential_energy] = bodies.energy(settings.gravity.0, true);
    let points = manifolds.points().iter();
    StepError {
        residual: sum.residual(),
        penetration: points.map(|p| -p.separation).fold(0.0, f32::max),
        kinetic_energy,
        potential_energy,
        energy_change: kinetic_energy + potential_energy - energy_before,
    }
}
