//! Numbers that only measurements can give: when threads help, how lists are cut, how far ahead memory is asked for.
//!
//! Each says its unit, and the machine and scene that chose it; "not measured apart" where it came with its feature and nobody has
//! varied it since. None has a meaning for physics, and all but the last ones (who is solved together) change times only, no bit of
//! motion. Most were chosen in November 2026 on two machines, an Intel Xeon with 2 MB and an AMD EPYC (Zen 3) with 512 KiB of
//! second-level cache a core, with two cores in use. `docs/decisions` has the measurements that still matter.
//!
//! What bodies may do (m, rad, shares of a size) stays beside its formula:
//! [sides of planes and sizes](crate::geometry::predicates), [contacts](crate::contact::narrow::sat),
//! [recycled contacts](crate::contact::pairs::recycle), [kept boxes](crate::contact::pairs::broad_phase),
//! [margins](crate::collide::proxies), [multipliers](crate::contact::impulses), [bonds](crate::fracture::bonds),
//! [caps](crate::slice::MeshSlicer), [rest](crate::solver::config::SleepConfig), [rotations](crate::bodies::free_rotation),
//! [crack areas](crate::slice::crack_area), [energy](crate::solver::batch).

// # Helpers: how they wait

/// Looks for a task (each some 100 ns) without yielding, then with: a helper whose core is wanted elsewhere must let go of it. Not
/// measured apart.
pub(crate) const HELPER_SPINS: u32 = 2000;

/// Pauses of the processor between two looks for a task, some 100 ns together: a core's other thread may be the leader's. Not
/// measured apart.
pub(crate) const HELPER_PAUSES: u32 = 4;

/// Looks for a task after the last phase until a helper goes: some 50 us. To wake one takes 25 to 40 us. Intel Xeon, two threads:
/// 144 pyramids of 15 cubes 0.81 ms a step instead of 0.96, a pile of 2000 1.22 instead of 1.39.
pub(crate) const HELPER_LINGER: u32 = 400;

// # Parts: how lists are cut for a team

/// Most parts that a list is cut into, for more threads than any of the machines had. Not measured apart.
pub(crate) const MAX_PARTS: usize = 8;

/// Most tasks of a list: the bits that the team takes tasks by.
pub(crate) const MAX_TASKS: usize = 32;

/// Parts of some 10 us from which a team is worth it: helpers take as long to come as one part takes. Not measured apart.
pub(crate) const PARTS_WORTH_HELP: usize = 4;

/// Pairs of a part of the narrow phase: some 10 us while all are at rest, 50 us while they land.
pub(crate) const PAIRS_PER_PART: usize = 128;

/// Most parts of the narrow phase, so that few buffers serve any number of pairs.
pub(crate) const MAX_PAIR_PARTS: usize = 32;

/// How many times as large as it should be a part of the narrow phase may become before pairs are dealt out anew. Intel Xeon, piles
/// of 16 000, with the flat lists of pairs; not measured apart.
pub(crate) const MAX_PART_GROWTH: usize = 2;

/// Manifolds of a part of the contact cache: some 10 us.
pub(crate) const MANIFOLDS_PER_PART: usize = 192;

/// Least manifolds of a part of a list that is read for the solve: each takes some 50 ns.
pub(crate) const MIN_MANIFOLDS_OF_PART: usize = 128;

/// Least manifolds of a part whose links are made: each takes some 10 ns.
pub(crate) const MIN_LINKS: usize = 512;

/// Least bodies of a part of a bisection, some 3 us of a pass.
pub(crate) const MIN_BISECTED_BODIES: usize = 512;

/// Least pairs of a part of which a team finds the largest extent: each takes some 5 ns.
pub(crate) const MIN_MEASURED_PAIRS: usize = 1024;

/// Least bodies of a part of which a team finds the largest inertia: each takes some 5 ns. Not measured apart.
pub(crate) const MIN_MEASURED_BODIES: usize = 1024;

/// Least bodies of a part that is moved: each takes some 15 ns.
pub(crate) const MIN_MOVED_BODIES: usize = 256;

/// Least bodies of a part whose boxes are looked at: each takes some 20 ns.
pub(crate) const MIN_PROXIES: usize = 256;

/// Least rows of a part of a table of entities: each takes some 10 ns.
pub(crate) const MIN_WRITTEN_ROWS: usize = 512;

// # Thresholds: from when on a team is called

/// Manifolds from which it pays to wake helpers for the solve: about 100 us of work, ten times what they take to come.
pub(crate) const MANIFOLDS_WORTH_HELP: usize = 256;

/// Manifolds from which it pays to have helpers look at them that are here anyway. Intel Xeon, as [`HELPER_LINGER`].
pub(crate) const MANIFOLDS_WORTH_THOSE_PRESENT: usize = 1024;

/// Manifolds of a batch from which all threads solve it together: there are several subdomains then.
pub(crate) const MANIFOLDS_WORTH_A_TEAM: usize = 2 * MIN_LEAF_MANIFOLDS;

/// Bodies from which it pays to have helpers move them that are here anyway: each takes some 15 ns. Intel Xeon, as
/// [`HELPER_LINGER`].
pub(crate) const MOVED_BODIES_WORTH_HELP: usize = 512;

/// Bodies from which it pays to have helpers look at their boxes: each takes some 20 ns. Two threads of an Intel Xeon: a pile of
/// 2000 1.61 ms a step instead of 1.68, of 4000 3.31 instead of 3.37.
pub(crate) const PROXIES_WORTH_HELP: usize = 1024;

/// Bodies from which it pays to have their entities written by a team: 20 us of work. Not measured apart.
pub(crate) const ENTITIES_WORTH_HELP: usize = 2048;

// # Memory: what is asked for before it is read, and in which order it lies

/// Bytes that a core's second-level cache keeps of what is gone through again and again; most have 512 KiB to 2 MiB. Sweeps over
/// more ask for their blocks ahead. AMD EPYC: nothing to gain with a pile of 2000, 10.2 and 9.6 ms a step with 8000; pyramids of 15
/// cubes lose 2 to 4 % if all batches ask.
pub(crate) const NEAR_CACHE: usize = 1 << 19;

/// How many blocks ahead of a sweep they are asked for: some 200 ns, in which far memory answers. AMD EPYC, piles of 16 000 and
/// 32 000: two, five and eight are within 3 %, one gains nothing.
pub(crate) const BLOCKS_AHEAD: usize = 3;

/// The same in points.
pub(crate) const POINTS_AHEAD: usize = 6;

/// The same in blocks for what a block needs to know of bodies besides their velocities.
pub(crate) const BODIES_AHEAD: usize = 2;

/// Bodies from which their displacements are asked for ahead: 192 KiB, which are gone from the near cache when all contacts have
/// been gone through. AMD EPYC, pile of 32 000: the first sweep of a sub-step takes a quarter less time.
pub(crate) const FAR_BODIES: usize = 6144;

/// How many blocks ahead the manifolds that they are filled from are asked for. Chosen with [`PAIRS_AHEAD`]; two gained as well.
pub(crate) const FILLED_BLOCKS_AHEAD: usize = 4;

/// How many points ahead they are asked for while blocks are filled. Not measured apart.
pub(crate) const FILLED_POINTS_AHEAD: usize = 6;

/// How many touching pairs ahead their touches and bodies are asked for. Pile of 16 000 at rest: narrow phase 7.5 ms instead of
/// 13.2, with 2000 0.48 instead of 0.65 (with four).
pub(crate) const PAIRS_AHEAD: usize = 8;

/// Pairs that get their quick look before the first of them gets a closer one: a bit each. Pile of 32 000: 8.8 to 9.0 ms instead of 9.8
/// to 10.0, 2000 the same.
pub(crate) const PAIR_RUN: usize = 64;

/// Touches from which it pays to have them in the order of the pairs, 1 MB: fewer are in the second-level cache. Intel Xeon, pile of
/// 16 000: manifolds are written in 2.0 ms instead of 3.3.
pub(crate) const TOUCHES_WORTH_SORTING: usize = 4096;

/// Of so many touches, one may have come since they were sorted, and lie anywhere. Not measured apart.
pub(crate) const TOUCH_DISORDER: usize = 8;

/// Of so many blocks, one may follow the motion; if more do, all contacts are asked in each sub-step. Pile of 32 000, one thread:
/// filling and following took 4.7 and 0.85 ms a step when there was no list, 3.4 and 0.2 with it.
pub(crate) const BLOCKS_PER_FOLLOWING: usize = 8;

/// Rows of a table whose ticks of change are compared at once. Not measured apart.
pub(crate) const COMPARED_ROWS: usize = 64;

/// From how many turning bodies on all eight lanes are calculated, the unused ones in vain. Not measured apart.
pub(crate) const SPINS_WORTH_LANES: usize = 4;

/// How many of the nearest sites of a Voronoi cell are sorted at a time. A cell has about 15 walls, and a few more sites are looked at
/// before it is known to be complete.
pub(crate) const NEAREST_SITES: usize = 32;

/// A mesh of more triangles than this is divided before more cells than [`CELLS_OF_A_PART`] are cut out of it. Not measured apart.
pub(crate) const TRIANGLES_OF_A_PART: usize = 2000;

/// As many cells are cut out of one part of a mesh: with 2 or 5 a body of 28 800 triangles takes 3 % and 4 % more instructions to be cut into
/// 50 cells (callgrind, AMD EPYC, 2026-11-27).
pub(crate) const CELLS_OF_A_PART: usize = 3;

/// What a triangle that may reach into a cell counts for when the cell takes what it needs, in triangles that a plane is held against.
pub(crate) const SOLID_PASSES: usize = 2;

/// Planes that a triangle of a mesh is held against, on the mean, when the mesh is cut into many cells, and what counts for them: of 28 800
/// triangles and 50 cells.
pub(crate) const PASSES_OF_A_CUT: usize = 22;

// # Who is solved together
//
// What is here changes the order of contacts, and so the last bits of motion: golden hashes are made anew with it.

/// Manifolds that take as long to solve as a joint. Not measured apart.
pub(crate) const JOINT_WEIGHT: usize = 6;

/// Updates of contact points that a solution of one joint counts as, of which each sweep makes one. It takes some forty of them (estimated from
/// profiles of ragdolls); a fourth is counted, for sweeps are also what couples contacts with joints. Not measured apart.
pub(crate) const JOINT_UPDATES: usize = 10;

/// Calm islands are solved together until they have this many manifolds: enough to fill the lanes of their blocks. Not measured
/// apart.
pub(crate) const BATCH_MANIFOLDS: usize = 192;

/// Islands whose contacts all share a body that are solved together, each as if it were alone: as many as a near cache keeps.
pub(crate) const LONE_ISLANDS: usize = 64;

/// Most manifolds of such an island. On hills of triangles of 0.7 m, one body of half a meter in a hundred has more.
pub(crate) const LONE_MANIFOLDS: usize = 8;

/// Manifolds from which an island is large for a look at whether it breaks: a tenth of a millisecond, which nobody minds to spend
/// twice.
pub(crate) const PROBED_MANIFOLDS: usize = 192;

/// Least manifolds of a leaf, on average: some 50 us of a sweep, a hundred times what threads need to meet. A cut costs structures
/// precision, for support gets across it once per sweep only, so there are no more of them than pay: a pyramid of base 50 in two
/// leaves moves by 160, 244, 58 and 7.1 mm with 3, 4, 6 sub-steps and the defaults, whole by 150, 104, 53 and 4.5.
pub(crate) const MIN_LEAF_MANIFOLDS: usize = 2000;

/// Most leaves of an island. Intel Xeon, pile of 32 000: 76.9 ms a step on one thread and 42.4 on two, with eight 84.4 and 50.3; of
/// 16 000 the same.
pub(crate) const MAX_LEAVES: usize = 16;

/// Places for a cut along an axis. Odd, so that none is in the middle, where symmetric structures have bodies that rounding would move
/// across.
pub(crate) const CUT_PLACES: usize = 61;
