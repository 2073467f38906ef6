//! What the user may choose.

/// How far an import may go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImportOptions {
    /// The largest area that new faces may have to close a part, as a share of the part's own area. 0 fills no hole; the
    /// box without a bottom needs a fifth, a flat tile without an underside almost 1.
    pub max_fill: f32,
    /// What becomes of parts that stay open.
    pub open_parts: OpenParts,
    /// How near to each other border points may be to count as one, as a share of the model's size.
    pub weld_distance: f32,
    /// Material slot of the new faces; `None` for that of a neighbor.
    pub fill_material: Option<u16>,
}

impl Default for ImportOptions {
    /// Fills holes up to half of a part's area; open parts ride along.
    fn default() -> Self {
        Self {
            max_fill: 0.5,
            open_parts: OpenParts::default(),
            weld_distance: 1e-5,
            fill_material: None,
        }
    }
}

/// What becomes of parts that stay open.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum OpenParts {
    /// They ride along as sheets (see [`TriMesh::with_sheets`](crate::geometry::TriMesh::with_sheets)): drawn and cut with
    /// the rest, without caps.
    #[default]
    Ride,
    /// They are left out.
    LeaveOut,
    /// They get a back at this distance (m) behind their faces, and a rim: flags, cards and leaves become solid.
    Thicken(f32),
}
