// Rigid transforms without Eigen, for those who only move a base pose.
#pragma once

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

// A level base whose y points along L's -z.
Rigid LevelBase();

}  // namespace omni::alignment
