//! Blows: what they break, and what of them acts before that.

use crate::bodies::breaking::{Blow, ImpactLoad};
use crate::bodies::store::Bodies;
use crate::fracture::BreakingImpact;
use crate::fracture::pieces::PieceSet;
use crate::geometry::Compound;
use crate::math::rotate;
use crate::slice::{Cutting, Fracturable, Impact};
use crate::solver::contact_solver::ContactSolver;
use glam::Vec3;

impl Blow {
    /// What the fracture is reported with.
    pub(super) fn report(&self, bodies: &Bodies, withstood: f32) -> BreakingImpact {
        let ImpactLoad { impulse, energy } = self.load;
        let center = bodies.center_of_mass(self.slot);
        BreakingImpact {
            impulse,
            energy,
            withstood,
            by: self.strongest.map(|(by, _)| (by, bodies.id(by))),
            point: center + self.moment / impulse,
            direction: self.direction.normalize_or(Vec3::Y),
        }
    }

    /// The share of the impulses that acts before the body breaks: what it bears, and what the cracks take.
    ///
    /// The first share `s` of a plastic blow with energy `E` takes `E (1 - (1 - s)^2)`: the approach is fastest at the
    /// start.
    pub(super) fn withstood(&self, bodies: &Bodies, division: &PieceSet) -> f32 {
        withstood(bodies, self.slot, self.load, division)
    }

    /// The manifolds that gave it, and the shares of their impulses that act when this share of it does.
    pub(super) fn shares(&self, withstood: f32) -> impl Iterator<Item = (u32, f32)> {
        let contacts = self.contacts.iter();
        contacts.map(move |&(index, part)| (index, part * withstood))
    }

    /// How much of it acted, of a share that should have, when these impulses did by manifold (N s, sorted by index).
    pub(super) fn acted(&self, share: f32, acted: &[(u32, f32)]) -> f32 {
        let of_contact = |&(index, _): &(u32, f32)| {
            let place = acted.binary_search_by_key(&index, |&(index, _)| index);
            place.map_or(0.0, |place| acted[place].1)
        };
        let impulse: f32 = self.contacts.iter().map(of_contact).sum();
        share.min(impulse.max(0.0) / self.load.impulse)
    }

    /// The same where bonds within the body break, and take the work.
    pub(super) fn withstood_by_bonds(&self) -> f32 {
        let taken = self.bond_work / self.load.energy;
        1.0 - (1.0 - taken).max(0.0).sqrt()
    }

    /// The blow as the body feels it, body's frame.
    pub(super) fn impact(&self, bodies: &Bodies) -> Impact {
        let to_body = bodies.pose(self.slot).rotation.inverse();
        // Squeezed from opposite sides, the impulses cancel; any direction across the body is as good as another then.
        let direction = rotate(to_body, self.direction).normalize_or(Vec3::Y);
        Impact {
            point: rotate(to_body, self.moment / self.load.impulse) + bodies.mass(self.slot).center,
            normal: direction,
            impulse: self.load.impulse,
            energy: self.load.energy,
        }
    }
}

/// The bonds that a blow breaks, after it has worn those that it leaves whole: with those that are worn out by it.
pub(super) fn wear_others(bodies: &mut Bodies, blow: &Blow) -> Vec<u32> {
    let mut broken = blow.bonds.clone();
    if let Some(energy) = bodies.fatigue(blow.slot).map(|it| it.energy)
        && !blow.strained.is_empty()
    {
        let share = blow.load.energy / energy;
        broken.extend(bodies.wear_bonds(blow.slot, &blow.strained, share));
        broken.sort_unstable();
    }
    broken
}

/// The share of a blow to the body in `slot` that acts before it breaks, see [`Blow::withstood`].
pub(super) fn withstood(bodies: &Bodies, slot: u32, load: ImpactLoad, division: &PieceSet) -> f32 {
    let Some(fracturable) = bodies.fracturable(slot) else {
        return 0.0;
    };
    let ImpactLoad { impulse, energy } = load;
    let cracks = fracturable.toughness * division.crack_area() as f32;
    let taken = fracturable.min_energy.max(cracks) / energy;
    let by_energy = if taken > 0.0 {
        1.0 - (1.0 - taken).max(0.0).sqrt()
    } else {
        0.0
    };
    (bodies.strength(slot) / impulse).max(by_energy).min(1.0)
}

/// The blows that break something, by the bodies' ids. Of a body that contacts do not move, and that was hit in several places at once, the
/// hardest one counts.
pub(super) fn hardest_blows<'s>(bodies: &Bodies, solver: &'s ContactSolver) -> Vec<&'s Blow> {
    let mut blows: Vec<&Blow> = solver.breaking().collect();
    blows.sort_by(|a, b| {
        let by_impulse = b.load.impulse.total_cmp(&a.load.impulse);
        bodies.id(a.slot).cmp(&bodies.id(b.slot)).then(by_impulse)
    });
    blows.dedup_by_key(|blow| blow.slot);
    blows
}

/// How a blow divides the body in `slot`, into at most `most` pieces; nothing if it does not pay for a crack.
///
/// Who has fewer pieces to give asks again: a pattern of cells that is cut short does not fill the body.
pub(super) fn cutting(bodies: &Bodies, slot: u32, impact: &Impact, most: usize) -> Option<Cutting> {
    let fracturable = bodies.fracturable(slot)?;
    let (hull, impact) = match bodies.compound(slot) {
        Some(compound) => {
            let part = &compound.parts()[struck_part(compound, impact.point)];
            let own = Impact {
                point: part.pose.inverse_transform_point(impact.point),
                normal: rotate(part.pose.rotation.inverse(), impact.normal),
                ..*impact
            };
            (part.shape.hull(), own)
        }
        None => (bodies.convex(slot)?.hull(), *impact),
    };
    let most = u32::try_from(most).unwrap_or(u32::MAX);
    let strength = bodies.strength(slot);
    if strength < fracturable.strength {
        let worn = Fracturable {
            strength,
            ..fracturable.clone()
        };
        return worn.cutting(&impact, hull, most);
    }
    fracturable.cutting(&impact, hull, most)
}

/// The part that a point is in, or nearest to; the first on a tie.
pub(super) fn struck_part(compound: &Compound, point: Vec3) -> usize {
    let parts = compound.parts().iter();
    let heights = parts.map(|part| part.height_of(point)).enumerate();
    let nearest = heights.min_by(|(_, a), (_, b)| a.total_cmp(b));
    nearest.map_or(0, |(part, _)| part)
}

impl BreakingImpact {
    /// Impulse that acted on the body before it broke, N s.
    pub fn borne_impulse(&self) -> f32 {
        self.withstood * self.impulse
    }

    /// Kinetic energy that it took to break the body, J: what the withstood share of a plastic blow takes.
    pub fn borne_energy(&self) -> f32 {
        self.energy * self.withstood * (2.0 - self.withstood)
    }
}
