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

  /// Where a trial strain returns to, in its order.
  struct Return
  {
    double stress[3], elastic_strain[3], plastic_increment;
    double status;   ///< Status; numbers of one kind fill vector registers
    double order[3]; ///< which trial strains are the largest, the middle and the smallest one
    bool extension;  ///< the second plane of an edge is 1-2 rather than 2-3
  };

  /// Without branches, so that StressLanes asks several points at once in vectors.
  KOKKOS_FORCEINLINE_FUNCTION Return find_return(const double (&strain)[3], const HenckyElasticity& elasticity) const
  {
    const double lame = elasticity.lame, shear = elasticity.shear;
    const double pressure = lame * (strain[0] + strain[1] + strain[2]);
    const double trial[3] = {pressure + 2. * shear * strain[0], pressure + 2. * shear * strain[1],
                             pressure + 2. * shear * strain[2]};
    Return result;
    double s[3] = {strain[0], strain[1], strain[2]};
    sort(s, result.order);
    for (double& sorted : s)
      sorted = pressure + 2. * shear * sorted;

    const double strength = 2. * cohesion * cos_phi;
    const double f13 = (1. + sin_phi) * s[0] - (1. - sin_phi) * s[2] - strength;
    const bool elastic = f13 <= 2. * shear * yield_tolerance;

    // The return to the plane 1-3.
    const double a = own_stiffness(elasticity);
    const double level = 2. * lame * sin_psi; // stress relieved by unit flow: of the middle, the high, the low one
    const double high = level + 2. * shear * (1. + sin_psi), low = level - 2. * shear * (1. - sin_psi);
    const double multiplier = f13 / a;
    const double plane[3] = {s[0] - multiplier * high, s[1] - multiplier * level, s[2] - multiplier * low};
    const bool extension = plane[2] > plane[1], on_edge = extension || plane[1] > plane[0];

    // The second plane is 1-2 on the edge of extension, 2-3 on that of compression.
    const double sign = extension ? 1. : -1.;
    const double b = neighbour_stiffness(elasticity, sign);
    const double scale = 1. / (stiffness_difference(elasticity, sign) * (a + b));
    const double f2 =
        (1. + sin_phi) * (extension ? s[0] : s[1]) - (1. - sin_phi) * (extension ? s[1] : s[2]) - strength;
    const double first = scale * (a * f13 - b * f2), second = scale * (a * f2 - b * f13);
    const double top = s[0] - first * high - second * (extension ? high : level);
    const double middle = s[1] - first * level - second * (extension ? low : high);
    const double bottom = s[2] - first * low - second * (extension ? level : low);
    const double equal = 0.5 * (middle + (extension ? bottom : top)); // equal to the last bit
    const double edge[3] = {extension ? top : equal, equal, extension ? equal : bottom};
    const bool at_apex = edge[0] < edge[2];
    const double apex = 0.5 * strength / sin_phi;

    double sorted[3];
    for (int i = 0; i < 3; ++i)
      sorted[i] = !on_edge ? plane[i] : at_apex ? apex : edge[i];
    for (int i = 0; i < 3; ++i)
    {
      const double plastic = result.order[0] == i ? sorted[0] : result.order[1] == i ? sorted[1] : sorted[2];
      result.stress[i] = elastic ? trial[i] : plastic;
    }
    const double mean = (result.stress[0] + result.stress[1] + result.stress[2]) / 3., flexibility = 0.5 / shear;
    const double volumetric = mean / (3. * elasticity.bulk());
    double lost[3];
    for (int i = 0; i < 3; ++i)
    {
      result.elastic_strain[i] = elastic ? strain[i] : volumetric + flexibility * (result.stress[i] - mean);
      lost[i] = strain[i] - result.elastic_strain[i];
    }
    const double x = lost[0] - lost[1], y = lost[1] - lost[2], z = lost[2] - lost[0];
    result.plastic_increment = std::sqrt(2. / 9. * (x * x + y * y + z * z));
    result.status = elastic    ? number(Status::elastic)
                    : !on_edge ? number(Status::plastic)
                    : at_apex  ? number(Status::apex)
                               : number(Status::edge);
    result.extension = extension;
    return result;
  }

  template <bool with_tangent>
  KEDGE_FUNCTION Response respond(const Eigen::Vector3d& trial_strain, const HenckyElasticity& elasticity) const
  {
    const Return found = find_return({trial_strain[0], trial_strain[1], trial_strain[2]}, elasticity);
    Response response;
    response.status = static_cast<Status>(static_cast<int>(found.status));
    if (response.status == Status::elastic)
      return elastic_response<with_tangent>(trial_strain, elasticity);
    if (response.status == Status::apex)
      return apex_response<with_tangent>(trial_strain, elasticity, found.stress[0]);
    for (int i = 0; i < 3; ++i)
    {
      response.stress[i] = found.stress[i];
      response.elastic_strain[i] = found.elastic_strain[i];
    }
    response.plastic_increment = found.plastic_increment;
    response.residual_stiffness = 0.;
    if constexpr (with_tangent)
      set_tangent(found, trial_strain, elasticity, response);
    return response;
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
    double sorted[3] = {trial_strain[0], trial_strain[1], trial_strain[2]}, position[3];
    sort(sorted, position);
    const int order[3] = {int(position[0]), int(position[1]), int(position[2])};
    const Eigen::Vector3d trial = elasticity.stress(Eigen::Vector3d(sorted[0], sorted[1], sorted[2]));
    const bool extension = response.stress[order[1]] == response.stress[order[2]];
    const Eigen::Vector3d rate = response.status == Status::plastic ? plane_rate(change, trial, elasticity)
                                                                    : edge_rate(change, trial, elasticity, extension);
    Eigen::Vector3d unsorted;
    for (int i = 0; i < 3; ++i)
      unsorted[order[i]] = rate[i];
    return unsorted;
  }

private:
  KEDGE_FUNCTION static constexpr double number(const Status status) { return static_cast<int>(status); }

  /// The stiffness between the normals of two planes: a of a plane with itself, b of it with its neighbour on the edge
  /// of extension (sign 1) or of compression (-1), and a - b, without cancellation.
  KEDGE_FUNCTION double own_stiffness(const HenckyElasticity& elasticity) const
  {
    return 4. * elasticity.lame * sin_phi * sin_psi + 4. * elasticity.shear * (1. + sin_phi * sin_psi);
  }
  KEDGE_FUNCTION double neighbour_stiffness(const HenckyElasticity& elasticity, const double sign) const
  {
    return 4. * elasticity.lame * sin_phi * sin_psi +
           2. * elasticity.shear * (1. + sign * sin_phi) * (1. + sign * sin_psi);
  }
  KEDGE_FUNCTION double stiffness_difference(const HenckyElasticity& elasticity, const double sign) const
  {
    return 2. * elasticity.shear * (1. - sign * sin_phi) * (1. - sign * sin_psi);
  }
  /// The derivative of sin(phi) sin(psi) in them.
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
    const double b = neighbour_stiffness(elasticity, sign);
    const double b_rate =
        4. * lame * product_rate(change) +
        2. * shear * sign * (change.sin_phi * (1. + sign * sin_psi) + change.sin_psi * (1. + sign * sin_phi));
    const double inverse = 1. / (stiffness_difference(elasticity, sign) * (a + b));
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

  /// Sorts strains, largest first, without branches. `order` receives where they were.
  KOKKOS_FORCEINLINE_FUNCTION static void sort(double (&strain)[3], double (&order)[3])
  {
    for (int i = 0; i < 3; ++i)
      order[i] = i;
    for (const int i : {0, 1, 0})
    {
      const bool swap = strain[i] < strain[i + 1];
      const double first = strain[i], second = strain[i + 1], one = order[i], other = order[i + 1];
      strain[i] = swap ? second : first;
      strain[i + 1] = swap ? first : second;
      order[i] = swap ? other : one;
      order[i + 1] = swap ? one : other;
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

  /// On the plane 1-3 and on edges.
  KEDGE_FUNCTION void set_tangent(const Return& found, const Eigen::Vector3d& trial_strain,
                                  const HenckyElasticity& elasticity, Response& response) const
  {
    // Of each plane: the stress that a unit of flow relieves, and the derivative of its multiplier with respect to the
    // sorted trial strain.
    const Eigen::Vector3d flow13 = stiff_normal(elasticity, sin_psi, 0, 2);
    const Eigen::Vector3d normal13 = stiff_normal(elasticity, sin_phi, 0, 2);
    const double a = own_stiffness(elasticity);
    Eigen::Vector3d flow2 = Eigen::Vector3d::Zero(), gradient13 = (1. / a) * normal13, gradient2 = flow2;
    if (response.status == Status::edge)
    {
      const int high = found.extension ? 0 : 1, low = found.extension ? 1 : 2;
      const double sign = found.extension ? 1. : -1.;
      const double b = neighbour_stiffness(elasticity, sign),
                   scale = 1. / (stiffness_difference(elasticity, sign) * (a + b));
      const Eigen::Vector3d normal2 = stiff_normal(elasticity, sin_phi, high, low);
      flow2 = stiff_normal(elasticity, sin_psi, high, low);
      gradient13 = scale * (a * normal13 - b * normal2);
      gradient2 = scale * (a * normal2 - b * normal13);
    }
    const int order[3] = {int(found.order[0]), int(found.order[1]), int(found.order[2])};
    const double two_g = 2. * elasticity.shear;
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 3; ++i)
        response.tangent(order[i], order[j]) =
            elasticity.lame + (i == j ? two_g : 0.) - flow13[i] * gradient13[j] - flow2[i] * gradient2[j];
    // Equal strains always end on an edge with equal stresses: then 0 / 0, which fmax turns into 0.
    for (int m = 0; m < 3; ++m)
    {
      const int n = m == 2 ? 0 : m + 1;
      const double quotient = (response.stress[m] - response.stress[n]) / (trial_strain[m] - trial_strain[n]);
      response.shear_stiffness[m] = std::fmin(std::fmax(quotient, 0.), two_g);
    }
  }
};
} // namespace kedge
