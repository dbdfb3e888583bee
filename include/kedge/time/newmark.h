// Newmark's integrator (Newmark 1959, J. Eng. Mech. Div. ASCE 85(3)) as functions of the displacement in a step.
#pragma once

#include <kedge/base/kokkos.h>

namespace kedge
{
/// One step of length dt (s). Unconditionally stable for 2 beta >= gamma >= 1/2; gamma > 1/2 damps high frequencies.
/// dt = 0 means statics, without acceleration.
struct Newmark
{
  double beta = 0.25, gamma = 0.5, dt = 0.;

  KEDGE_FUNCTION bool is_dynamic() const { return dt > 0.; }
  /// Whether a step depends on the acceleration at its start.
  KEDGE_FUNCTION bool needs_start_acceleration() const { return beta != 0.5 || gamma != 1.; }
  /// d acceleration / d displacement, 1/s2.
  KEDGE_FUNCTION double stiffness_factor() const { return 1. / (beta * dt * dt); }
  /// Acceleration at the end (m/s2) for the displacement in the step (m) and velocity and acceleration at its start.
  template <typename T>
  KEDGE_FUNCTION T acceleration(const T& displacement, const T& velocity, const T& acceleration) const
  {
    return (displacement - dt * velocity - dt * dt * (0.5 - beta) * acceleration) * stiffness_factor();
  }
  /// Change of the velocity in the step, m/s.
  template <typename T> KEDGE_FUNCTION T velocity_change(const T& start_acceleration, const T& end_acceleration) const
  {
    return dt * ((1. - gamma) * start_acceleration + gamma * end_acceleration);
  }
};
} // namespace kedge
