// Joints for Jolt: JoltC, which the adapter goes through otherwise, has none of its constraints.

#include <Jolt/Jolt.h>

#include <Jolt/Physics/Body/BodyLockMulti.h>
#include <Jolt/Physics/Collision/GroupFilterTable.h>
#include <Jolt/Physics/Constraints/FixedConstraint.h>
#include <Jolt/Physics/Constraints/HingeConstraint.h>
#include <Jolt/Physics/Constraints/PointConstraint.h>
#include <Jolt/Physics/Constraints/SliderConstraint.h>
#include <Jolt/Physics/Constraints/SwingTwistConstraint.h>
#include <Jolt/Physics/PhysicsSystem.h>
#include <Jolt/RegisterTypes.h>

using namespace JPH;

enum ArenaKind : int { FIXED, BALL, HINGE, SLIDER, CONE_TWIST };

/// A joint's frame on a body: where it is, its x axis and its y axis.
struct ArenaFrame {
	float point[3], x[3], y[3];
};

struct ArenaJoint {
	ArenaKind kind;
	ArenaFrame frames[2];
	/// Least and largest angle of a hinge, swing and twist of a cone.
	bool has_range;
	float range[2];
	/// Speed and largest torque of a motor, frequency and damping ratio of a spring.
	bool has_drive;
	float drive[2];
};

static Vec3 vec(const float (&p)[3]) {
	return Vec3(p[0], p[1], p[2]);
}

template <class Settings>
static void place_points(Settings &s, const ArenaJoint &j) {
	s.mSpace = EConstraintSpace::LocalToBodyCOM;
	s.mPoint1 = RVec3(vec(j.frames[0].point));
	s.mPoint2 = RVec3(vec(j.frames[1].point));
}

template <class Settings>
static void place_normals(Settings &s, const ArenaJoint &j) {
	s.mNormalAxis1 = vec(j.frames[0].y);
	s.mNormalAxis2 = vec(j.frames[1].y);
}

static TwoBodyConstraint *hinge(const ArenaJoint &j, Body &a, Body &b) {
	HingeConstraintSettings s;
	place_points(s, j);
	s.mHingeAxis1 = vec(j.frames[0].x);
	s.mHingeAxis2 = vec(j.frames[1].x);
	place_normals(s, j);
	if (j.has_range) {
		s.mLimitsMin = j.range[0];
		s.mLimitsMax = j.range[1];
	}
	if (j.has_drive)
		s.mMotorSettings.SetTorqueLimit(j.drive[1]);
	auto *made = static_cast<HingeConstraint *>(s.Create(a, b));
	if (j.has_drive) {
		made->SetMotorState(EMotorState::Velocity);
		made->SetTargetAngularVelocity(j.drive[0]);
	}
	return made;
}

static TwoBodyConstraint *slider(const ArenaJoint &j, Body &a, Body &b) {
	SliderConstraintSettings s;
	place_points(s, j);
	s.mSliderAxis1 = vec(j.frames[0].x);
	s.mSliderAxis2 = vec(j.frames[1].x);
	place_normals(s, j);
	if (j.has_drive)
		s.mMotorSettings = MotorSettings(j.drive[0], j.drive[1]);
	auto *made = static_cast<SliderConstraint *>(s.Create(a, b));
	if (j.has_drive) {
		made->SetMotorState(EMotorState::Position);
		made->SetTargetPosition(0.0f);
	}
	return made;
}

static TwoBodyConstraint *cone_twist(const ArenaJoint &j, Body &a, Body &b) {
	SwingTwistConstraintSettings s;
	s.mSpace = EConstraintSpace::LocalToBodyCOM;
	s.mPosition1 = RVec3(vec(j.frames[0].point));
	s.mPosition2 = RVec3(vec(j.frames[1].point));
	s.mTwistAxis1 = vec(j.frames[0].x);
	s.mTwistAxis2 = vec(j.frames[1].x);
	s.mPlaneAxis1 = vec(j.frames[0].y);
	s.mPlaneAxis2 = vec(j.frames[1].y);
	s.mNormalHalfConeAngle = s.mPlaneHalfConeAngle = j.range[0];
	s.mTwistMinAngle = -j.range[1];
	s.mTwistMaxAngle = j.range[1];
	return s.Create(a, b);
}

static TwoBodyConstraint *fixed(const ArenaJoint &j, Body &a, Body &b) {
	FixedConstraintSettings s;
	place_points(s, j);
	s.mAxisX1 = vec(j.frames[0].x);
	s.mAxisX2 = vec(j.frames[1].x);
	s.mAxisY1 = vec(j.frames[0].y);
	s.mAxisY2 = vec(j.frames[1].y);
	return s.Create(a, b);
}

static TwoBodyConstraint *ball(const ArenaJoint &j, Body &a, Body &b) {
	PointConstraintSettings s;
	place_points(s, j);
	return s.Create(a, b);
}

extern "C" {

/// Whether this file was compiled with the layout and features of the library.
bool arena_jolt_fits() {
	return VerifyJoltVersionID();
}

/// Adds a joint between two bodies, with so many velocity and position iterations; 0: as Jolt has it.
void arena_jolt_join(void *system, const uint32_t bodies[2], const ArenaJoint *joint, const uint32_t iterations[2]) {
	auto &physics = *static_cast<PhysicsSystem *>(system);
	BodyID ids[2] = { BodyID(bodies[0]), BodyID(bodies[1]) };
	BodyLockMultiWrite lock(physics.GetBodyLockInterface(), ids, 2);
	Body &a = *lock.GetBody(0), &b = *lock.GetBody(1);
	TwoBodyConstraint *made = nullptr;
	switch (joint->kind) {
	case FIXED: made = fixed(*joint, a, b); break;
	case BALL: made = ball(*joint, a, b); break;
	case HINGE: made = hinge(*joint, a, b); break;
	case SLIDER: made = slider(*joint, a, b); break;
	case CONE_TWIST: made = cone_twist(*joint, a, b); break;
	}
	made->SetNumVelocityStepsOverride(iterations[0]);
	made->SetNumPositionStepsOverride(iterations[1]);
	physics.AddConstraint(made);
}

/// A table of `members` bodies that hang together, between whose pairs `without_contacts` nothing touches. Bodies of other tables do.
void arena_jolt_group(void *system, uint32_t group, const uint32_t *bodies, uint32_t members, const uint32_t (*without_contacts)[2], uint32_t pairs) {
	auto &physics = *static_cast<PhysicsSystem *>(system);
	Ref<GroupFilterTable> table = new GroupFilterTable(members);
	for (uint32_t i = 0; i < pairs; ++i)
		table->DisableCollision(without_contacts[i][0], without_contacts[i][1]);
	for (uint32_t i = 0; i < members; ++i) {
		BodyLockWrite lock(physics.GetBodyLockInterface(), BodyID(bodies[i]));
		lock.GetBody().SetCollisionGroup(CollisionGroup(table, group, i));
	}
}

}
