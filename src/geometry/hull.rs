//! Convex hull of a point cloud.
