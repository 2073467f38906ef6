//! Why something is not a convex hull.

/// Why points or faces do not make a convex hull.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HullError {
    /// A coordinate is NaN or infinite.
    #[error("point {point} is not finite")]
    NotFinite {
        /// Index of the point.
        point: usize,
    },
    /// Fewer than four points.
    #[error("a body needs at least 4 points, got {found}")]
    TooFewPoints {
        /// Number of points.
        found: usize,
    },
    /// The size of the points' bounding box, or their distance from the origin, is not within
    /// 1e-6 m to 1e6 m.
    #[error("a body of size {size} m is outside the range of 1e-6 m to 1e6 m")]
    Size {
        /// Length scale, m.
        size: f64,
    },
    /// All points lie on one plane, line or point, within the tolerance.
    #[error("the points are flat: thickness {thickness} m at size {size} m")]
    Flat {
        /// Smallest extent found, m.
        thickness: f64,
        /// Diagonal of the bounding box, m.
        size: f64,
    },
    /// A face has fewer than three corners, or no area, so that it has no plane.
    #[error("face {face} has no area")]
    DegenerateFace {
        /// Index of the face.
        face: usize,
    },
    /// A face names a vertex that does not exist.
    #[error("face {face} names vertex {index}, but there are {vertices}")]
    IndexOutOfRange {
        /// Index of the face.
        face: usize,
        /// The vertex it names.
        index: u32,
        /// Number of vertices.
        vertices: usize,
    },
    /// A length of a primitive is not positive and finite.
    #[error("{name} must be positive and finite, got {value} m")]
    Length {
        /// Which length.
        name: &'static str,
        /// Its value, m.
        value: f32,
    },
    /// A count that describes a primitive is out of range.
    #[error("{name} must be between {least} and {most}, got {value}")]
    Count {
        /// What is counted.
        name: &'static str,
        /// Its value.
        value: u32,
        /// Least allowed value.
        least: u32,
        /// Greatest allowed value.
        most: u32,
    },
    /// The mesh that the hull was to be made from is not usable.
    #[error(transparent)]
    Mesh(#[from] crate::geometry::MeshError),
    /// The result does not pass [`ConvexHull::validate`](crate::geometry::ConvexHull::validate).
    #[error("the hull is not valid: {0}")]
    Invalid(#[from] HullDefect),
}

/// What is wrong with a hull; see [`ConvexHull::validate`](crate::geometry::ConvexHull::validate).
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum HullDefect {
    /// Vertices - edges + faces is not 2.
    #[error("Euler's formula fails: {vertices} - {edges} + {faces} is not 2")]
    Euler {
        /// Number of vertices.
        vertices: usize,
        /// Number of edges.
        edges: usize,
        /// Number of faces.
        faces: usize,
    },
    /// A face's edge has no partner in another face.
    #[error("edge {from}-{to} of face {face} has no partner")]
    Open {
        /// First vertex.
        from: u32,
        /// Second vertex.
        to: u32,
        /// Face.
        face: usize,
    },
    /// A vertex lies outside the plane of a face.
    #[error("vertex {vertex} lies {distance} m outside face {face}")]
    NotConvex {
        /// Vertex.
        vertex: usize,
        /// Face.
        face: usize,
        /// Distance, m.
        distance: f32,
    },
    /// The volume is zero or negative, so the faces do not point outwards.
    #[error("the faces enclose {volume} m3")]
    Inward {
        /// Signed volume, m3.
        volume: f64,
    },
}
