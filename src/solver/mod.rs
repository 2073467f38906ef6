//! One mixed linear complementarity problem, and the methods that solve it.
