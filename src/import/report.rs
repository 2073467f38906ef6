//! What an import found and did, part by part.

use glam::Vec3;
use std::fmt;

/// What an import found and did.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ImportReport {
    /// The parts of the model: what hangs together across edges, by object. The open parts of one object are one entry.
    pub parts: Vec<PartReport>,
    /// What the reader of the file has to say, such as lines that were left out.
    pub notes: Vec<String>,
}

/// One part of a model.
#[derive(Clone, Debug, PartialEq)]
pub struct PartReport {
    /// Name of the object, with the number of the part if the object has several.
    pub name: String,
    /// Middle of the box around it, m.
    pub center: Vec3,
    /// Edges of the box around it, m.
    pub size: Vec3,
    /// Triangles in the model.
    pub triangles: usize,
    /// What became of it.
    pub state: PartState,
    /// What was done to it.
    pub repairs: Repairs,
    /// Holes that were filled, or that stay if the part is open.
    pub holes: Vec<Hole>,
    /// Area of the faces that close the holes, as a share of the part's own area.
    pub fill_share: f32,
}

/// What became of a part.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum PartState {
    /// It was closed and is as it was.
    Closed,
    /// It was closed by repairs.
    Repaired,
    /// It is closed, but flat: two faces back to back, without volume.
    Flat,
    /// The inner wall of a hollow in another part.
    Hollow,
    /// Open, got a thickness.
    Thickened,
    /// Open, rides along as sheets.
    Riding,
    /// Open, left out.
    LeftOut,
}

/// What was done to a part, counted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Repairs {
    /// Triangles without area that were dropped.
    pub without_area: usize,
    /// Triangles that were there twice; one is left of each.
    pub doubled: usize,
    /// Triangles that faced against their neighbors and were turned.
    pub turned: usize,
    /// Border points that were joined with others nearly at the same place.
    pub joined: usize,
    /// Corners in the middle of a neighbor's edge, which got a corner there.
    pub divided: usize,
    /// Sides of edges that four or more triangles share, sorted out in pairs.
    pub paired: usize,
    /// Whether the part was inside out and was turned as a whole.
    pub inside_out: bool,
}

/// A hole in a part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hole {
    /// Mean of its corners, m.
    pub center: Vec3,
    /// Number of edges around it.
    pub edges: usize,
}

impl Repairs {
    pub(super) fn add(&mut self, other: &Self) {
        self.without_area += other.without_area;
        self.doubled += other.doubled;
        self.turned += other.turned;
        self.joined += other.joined;
        self.divided += other.divided;
        self.paired += other.paired;
        self.inside_out |= other.inside_out;
    }
}

impl ImportReport {
    /// How many parts became that.
    pub fn count(&self, state: PartState) -> usize {
        self.parts.iter().filter(|part| part.state == state).count()
    }

    /// Whether the model was closed and is as it was.
    pub fn is_untouched(&self) -> bool {
        let untouched = |part: &PartReport| {
            matches!(part.state, PartState::Closed | PartState::Hollow)
                && part.repairs == Repairs::default()
        };
        self.parts.iter().all(untouched)
    }
}

impl fmt::Display for ImportReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for part in &self.parts {
            writeln!(f, "{part}")?;
        }
        for note in &self.notes {
            writeln!(f, "note: {note}")?;
        }
        Ok(())
    }
}

impl fmt::Display for PartReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            name,
            center,
            size,
            triangles,
            ..
        } = self;
        write!(
            f,
            "{name}: {triangles} triangles in a box of {:.3} x {:.3} x {:.3} m at ({:.3}, {:.3}, {:.3}), ",
            size.x, size.y, size.z, center.x, center.y, center.z
        )?;
        f.write_str(match self.state {
            PartState::Closed => "closed",
            PartState::Repaired => "repaired",
            PartState::Flat => "two faces back to back, without volume",
            PartState::Hollow => "a hollow of another part",
            PartState::Thickened => "open, got a thickness",
            PartState::Riding => "open, rides along without caps",
            PartState::LeftOut => "open, left out",
        })?;
        self.repairs.fmt(f)?;
        let filled = self.state == PartState::Repaired;
        for hole in &self.holes {
            let Hole { center: c, edges } = hole;
            let what = if filled { "filled a hole" } else { "hole" };
            write!(
                f,
                "; {what} with {edges} edges at ({:.3}, {:.3}, {:.3})",
                c.x, c.y, c.z
            )?;
        }
        if !self.holes.is_empty() {
            let share = 100.0 * self.fill_share;
            let verb = if filled { "are" } else { "would be" };
            write!(
                f,
                "; the faces that close it {verb} {share:.0} % of its area"
            )?;
        }
        Ok(())
    }
}

impl fmt::Display for Repairs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let counts = [
            (self.without_area, "triangles without area dropped"),
            (self.doubled, "doubled triangles dropped"),
            (
                self.turned,
                "triangles turned that faced against their neighbors",
            ),
            (self.joined, "border points joined"),
            (self.divided, "edges divided at a neighbor's corner"),
            (self.paired, "edges of four and more triangles sorted out"),
        ];
        for (count, what) in counts.into_iter().filter(|&(count, _)| count > 0) {
            write!(f, "; {count} {what}")?;
        }
        if self.inside_out {
            f.write_str("; was inside out, turned")?;
        }
        Ok(())
    }
}
