// Rigid transforms without Eigen, for those who only move a base pose.
#pragma once

#include <vector>

#include "service/alignment/types.h"

namespace omni::alignment {

Rigid Compose(const Rigid& X_AB, const Rigid& X_BC);
Rigid Inverse(const Rigid& X_AB);
base::Vec3 TransformPoint(const Rigid& X_AB, const base::Vec3& p_B);

// Turned about L's y through B's origin, then shifted in L: how a person nudges a base.
Rigid NudgedPose(const Rigid& X_LB, double yaw_rad, const base::Vec3& shift_space_m);

// How far two base poses put a point of the base apart, and the angle between them.
double Distance_m(const Rigid& a, const Rigid& b, const base::Vec3& point_base_m);
double Angle_rad(const Rigid& a, const Rigid& b);

// Point sets onto each other in closed form: the start of every fit, and the textbook answer that tests compare with.
struct PointPair {
  base::Vec3 base_m;   // p_B
  base::Vec3 space_m;  // p_L
  double weight = 1;   // > 0
};

// X_LB that minimises sum w |p_L - X_LB p_B|^2, a rotation in any case (never a reflection). Three pairs that are not
// on a line, at least: else the rotation is one of many.   [Kabsch 1976, Umeyama 1991; docs/theory/alignment.md (1)]
Rigid FitSixDof(const std::vector<PointPair>& pairs);

// The same with gravity known in both: B's z is L's y, only yaw and place are free. Two pairs that are not one above
// the other, at least.   [docs/theory/alignment.md (2)]
Rigid FitFourDof(const std::vector<PointPair>& pairs);

// A level base whose y points along L's -z.
Rigid LevelBase();

}  // namespace omni::alignment
