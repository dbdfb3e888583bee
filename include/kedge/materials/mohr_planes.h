// Return to Mohr-Coulomb's planes, edges and apex in principal space.
#pragma once

#include <kedge/materials/response.h>

namespace kedge
{
/// f = (1 + sin(phi)) tau_1 - (1 - sin(phi)) tau_3 - 2 c cos(phi) with tau_1 >= tau_2 >= tau_3, tension positive; flow
/// from the same function with psi in place of phi. phi = psi = 0 is Tresca's law.
///
/// The planes are flat and the law of elasticity linear, so each return is closed form and exact: Clausen, Damkilde &
/// Andersen 2007 (Comput. Struct. 85). The return to the plane 1-3 decides the region: sorted stresses are final;
/// tau_3 > tau_2 or tau_2 > tau_1 send it to the edge of extension (tau_2 = tau_3) or of compression (tau_1 = tau_2);
/// tau_1 < tau_3 on the edge sends it to the apex tau_i = c cot(phi), and so it does on either edge where both
/// inequalities hold. Each test is zero on the common boundary of two regions, where their returns agree: the stress is
/// continuous in the trial strain, for psi != phi too.
struct MohrPlanes
{
  double sin_phi;
  double cos_phi;
  double sin_psi;
  double cohesion; ///< Pa, > 0

  template <bool with_tangent>
  KEDGE_FUNCTION Response respond(const Eigen::Vector3d& trial_strain, const HenckyElasticity& elasticity) const
  {
    int order[3];
    sort(trial_strain, order);
    const Eigen::Vector3d trial =
        elasticity.stress(Eigen::Vector3d(trial_strain[order[0]], trial_strain[order[1]], trial_strain[order[2]]));

    const double strength = 2. * cohesion * cos_phi;
    const double f13 = (1. + sin_phi) * trial[0] - (1. - sin_phi) * trial[2] - strength;
    if (f13 <= 2. * elasticity.shear * yield_tolerance)
      return elastic_response<with_tangent>(trial_strain, elasticity);

    // The stiffness between the normals of two planes: a for a plane with itself, b for it with its neighbour.
    const double shared = 4. * elasticity.lame * sin_phi * sin_psi;
    const double a = shared + 4. * elasticity.shear * (1. + sin_phi * sin_psi);
    const Eigen::Vector3d flow13 = stiff_normal(elasticity, sin_psi, 0, 2);
    Eigen::Vector3d stress = trial - (f13 / a) * flow13;
    const bool extension = stress[2] > stress[1], compression = stress[1] > stress[0];
    Planes planes = {flow13, Eigen::Vector3d::Zero(), (1. / a) * stiff_normal(elasticity, sin_phi, 0, 2),
                     Eigen::Vector3d::Zero()};
    if (!(extension || compression))
      return finish<with_tangent>(order, stress, planes, trial_strain, elasticity, Status::plastic);

    // The second plane is 1-2 on the edge of extension, 2-3 on that of compression.
    const int high = extension ? 0 : 1, low = extension ? 1 : 2, twin = extension ? 2 : 0;
    const double towards = (1. + sin_phi) * (1. + sin_psi), away = (1. - sin_phi) * (1. - sin_psi);
    const double b = shared + 2. * elasticity.shear * (extension ? towards : away);
    const double difference = 2. * elasticity.shear * (extension ? away : towards); // a - b, without cancellation
    const double inverse = 1. / (difference * (a + b));
    const double f2 = (1. + sin_phi) * trial[high] - (1. - sin_phi) * trial[low] - strength;
    planes.flow2 = stiff_normal(elasticity, sin_psi, high, low);
    stress = trial - (inverse * (a * f13 - b * f2)) * flow13 - (inverse * (a * f2 - b * f13)) * planes.flow2;
    stress[1] = stress[twin] = 0.5 * (stress[1] + stress[twin]); // equal to the last bit
    if (stress[0] < stress[2])
      return apex_response<with_tangent>(trial_strain, elasticity, 0.5 * strength / sin_phi);

    const Eigen::Vector3d normal13 = stiff_normal(elasticity, sin_phi, 0, 2);
    const Eigen::Vector3d normal2 = stiff_normal(elasticity, sin_phi, high, low);
    planes.gradient13 = inverse * (a * normal13 - b * normal2);
    planes.gradient2 = inverse * (a * normal2 - b * normal13);
    return finish<with_tangent>(order, stress, planes, trial_strain, elasticity, Status::edge);
  }

  /// d stress / d q at a fixed trial strain, where the angles' functions change by `change` with a parameter q and
  /// `response` is what these planes answer to the trial strain: the closed form differentiated. On an edge the
  /// multipliers solve [a b; b a] lambda = f.
  KEDGE_FUNCTION Eigen::Vector3d stress_rate(const MohrPlanes& change, const Response& response,
                                             const Eigen::Vector3d& trial_strain,
                                             const HenckyElasticity& elasticity) const
  {
    if (response.status == Status::elastic)
      return Eigen::Vector3d::Zero();
    if (response.status == Status::apex)
      return Eigen::Vector3d::Constant(cohesion * (change.cos_phi - cos_phi / sin_phi * change.sin_phi) / sin_phi);
    int order[3];
    sort(trial_strain, order);
    const Eigen::Vector3d trial =
        elasticity.stress(Eigen::Vector3d(trial_strain[order[0]], trial_strain[order[1]], trial_strain[order[2]]));
    const bool extension = response.stress[order[1]] == response.stress[order[2]];
    const Eigen::Vector3d rate = response.status == Status::plastic ? plane_rate(change, trial, elasticity)
                                                                    : edge_rate(change, trial, elasticity, extension);
    Eigen::Vector3d unsorted;
    for (int i = 0; i < 3; ++i)
      unsorted[order[i]] = rate[i];
    return unsorted;
  }

private:
  /// The stiffness a of a plane with itself, and the derivative of sin(phi) sin(psi) in it.
  KEDGE_FUNCTION double own_stiffness(const HenckyElasticity& elasticity) const
  {
    return 4. * elasticity.lame * sin_phi * sin_psi + 4. * elasticity.shear * (1. + sin_phi * sin_psi);
  }
  KEDGE_FUNCTION double product_rate(const MohrPlanes& change) const
  {
    return change.sin_phi * sin_psi + sin_phi * change.sin_psi;
  }

  /// Yield function of the plane high-low at sorted stresses, and its derivative.
  KEDGE_FUNCTION double yield(const Eigen::Vector3d& trial, const int high, const int low) const
  {
    return (1. + sin_phi) * trial[high] - (1. - sin_phi) * trial[low] - 2. * cohesion * cos_phi;
  }
  KEDGE_FUNCTION double yield_rate(const MohrPlanes& change, const Eigen::Vector3d& trial, const int high,
                                   const int low) const
  {
    return change.sin_phi * (trial[high] + trial[low]) - 2. * cohesion * change.cos_phi;
  }

  /// d stiff_normal / d sine.
  KEDGE_FUNCTION static Eigen::Vector3d stiff_normal_rate(const HenckyElasticity& elasticity, const int high,
                                                          const int low)
  {
    Eigen::Vector3d rate = Eigen::Vector3d::Constant(2. * elasticity.lame);
    rate[high] += 2. * elasticity.shear;
    rate[low] += 2. * elasticity.shear;
    return rate;
  }

  /// Of the sorted stress on the plane 1-3.
  KEDGE_FUNCTION Eigen::Vector3d plane_rate(const MohrPlanes& change, const Eigen::Vector3d& trial,
                                            const HenckyElasticity& elasticity) const
  {
    const double a = own_stiffness(elasticity);
    const double a_rate = 4. * (elasticity.lame + elasticity.shear) * product_rate(change);
    const double multiplier = yield(trial, 0, 2) / a;
    const double multiplier_rate = (yield_rate(change, trial, 0, 2) - a_rate * multiplier) / a;
    return -multiplier_rate * stiff_normal(elasticity, sin_psi, 0, 2) -
           (multiplier * change.sin_psi) * stiff_normal_rate(elasticity, 0, 2);
  }

  /// Of the sorted stress on an edge.
  KEDGE_FUNCTION Eigen::Vector3d edge_rate(const MohrPlanes& change, const Eigen::Vector3d& trial,
                                           const HenckyElasticity& elasticity, const bool extension) const
  {
    const double lame = elasticity.lame, shear = elasticity.shear;
    const int high = extension ? 0 : 1, low = extension ? 1 : 2, twin = extension ? 2 : 0;
    const double sign = extension ? 1. : -1.;
    const double a = own_stiffness(elasticity), a_rate = 4. * (lame + shear) * product_rate(change);
    const double b = 4. * lame * sin_phi * sin_psi + 2. * shear * (1. + sign * sin_phi) * (1. + sign * sin_psi);
    const double b_rate =
        4. * lame * product_rate(change) +
        2. * shear * sign * (change.sin_phi * (1. + sign * sin_psi) + change.sin_psi * (1. + sign * sin_phi));
    const double difference = 2. * shear * (1. - sign * sin_phi) * (1. - sign * sin_psi); // a - b
    const double inverse = 1. / (difference * (a + b));
    const double f13 = yield(trial, 0, 2), f2 = yield(trial, high, low);
    const double first = inverse * (a * f13 - b * f2), second = inverse * (a * f2 - b * f13);
    const double f13_rate = yield_rate(change, trial, 0, 2) - a_rate * first - b_rate * second;
    const double f2_rate = yield_rate(change, trial, high, low) - b_rate * first - a_rate * second;
    Eigen::Vector3d rate = -inverse * (a * f13_rate - b * f2_rate) * stiff_normal(elasticity, sin_psi, 0, 2) -
                           inverse * (a * f2_rate - b * f13_rate) * stiff_normal(elasticity, sin_psi, high, low) -
                           (first * change.sin_psi) * stiff_normal_rate(elasticity, 0, 2) -
                           (second * change.sin_psi) * stiff_normal_rate(elasticity, high, low);
    rate[1] = rate[twin] = 0.5 * (rate[1] + rate[twin]);
    return rate;
  }

  /// Of the plane 1-3 and the second one: the stress that a unit of flow relieves, and the derivative of its multiplier
  /// with respect to the sorted trial strain.
  struct Planes
  {
    Eigen::Vector3d flow13, flow2, gradient13, gradient2;
  };

  /// Positions of the largest, the middle and the smallest strain.
  KEDGE_FUNCTION static void sort(const Eigen::Vector3d& strain, int (&order)[3])
  {
    order[0] = 0;
    order[1] = 1;
    order[2] = 2;
    sort_pair(strain, order[0], order[1]);
    sort_pair(strain, order[1], order[2]);
    sort_pair(strain, order[0], order[1]);
  }

  KEDGE_FUNCTION static void sort_pair(const Eigen::Vector3d& strain, int& first, int& second)
  {
    if (strain[first] < strain[second])
    {
      const int kept = first;
      first = second;
      second = kept;
    }
  }

  /// Elastic stiffness times the normal of the plane high-low, with the sine of phi (yield) or psi (flow).
  KEDGE_FUNCTION static Eigen::Vector3d stiff_normal(const HenckyElasticity& elasticity, const double sine,
                                                     const int high, const int low)
  {
    Eigen::Vector3d n = Eigen::Vector3d::Constant(2. * elasticity.lame * sine);
    n[high] += 2. * elasticity.shear * (1. + sine);
    n[low] -= 2. * elasticity.shear * (1. - sine);
    return n;
  }

  template <bool with_tangent>
  KEDGE_FUNCTION static Response finish(const int (&order)[3], const Eigen::Vector3d& sorted_stress,
                                        const Planes& planes, const Eigen::Vector3d& trial_strain,
                                        const HenckyElasticity& elasticity, const Status status)
  {
    Response response;
    for (int i = 0; i < 3; ++i)
      response.stress[order[i]] = sorted_stress[i];
    response.elastic_strain = elasticity.strain(response.stress);
    const Eigen::Vector3d plastic = trial_strain - response.elastic_strain;
    const double x = plastic[0] - plastic[1], y = plastic[1] - plastic[2], z = plastic[2] - plastic[0];
    response.plastic_increment = std::sqrt(2. / 9. * (x * x + y * y + z * z));
    response.residual_stiffness = 0.;
    response.status = status;
    if constexpr (with_tangent)
    {
      const double two_g = 2. * elasticity.shear;
      for (int j = 0; j < 3; ++j)
        for (int i = 0; i < 3; ++i)
          response.tangent(order[i], order[j]) = elasticity.lame + (i == j ? two_g : 0.) -
                                                 planes.flow13[i] * planes.gradient13[j] -
                                                 planes.flow2[i] * planes.gradient2[j];
      // Equal strains always end on an edge with equal stresses: then 0 / 0, which fmax turns into 0.
      for (int m = 0; m < 3; ++m)
      {
        const int n = m == 2 ? 0 : m + 1;
        const double quotient = (response.stress[m] - response.stress[n]) / (trial_strain[m] - trial_strain[n]);
        response.shear_stiffness[m] = std::fmin(std::fmax(quotient, 0.), two_g);
      }
    }
    return response;
  }
};
} // namespace kedge
