// Particles of a cell come to one pressure.
#include <cmath>
#include <kedge/assembly/deformation.h>
#include <kedge/assembly/volume_average.h>
#include <string>

namespace kedge
{
namespace
{
constexpr int most_iterations = 30;

template <int dim> struct SharedPressureKernel
{
  ParticleArrays particles;
  StencilSet stencils;
  CellGroups cells;
  Materials materials;
  // by particle
  View<double* [3]> strain; ///< trial principal strains for the particle's own dF
  View<double*> own_change; ///< ln J
  View<double*> offset;     ///< distance from the cell's mean stress at the start of the step, Pa
  View<double*> change;     ///< ln J*
  View<double*> pressure;   ///< p / J* - offset and the small spring, Pa
  View<double*> modulus;    ///< its derivative with ln J*, times J*

  KEDGE_FUNCTION double volume(const unsigned int p) const { return integration_volume(particles, stencils, p); }

  KEDGE_FUNCTION void operator()(const std::size_t c) const
  {
    const unsigned int begin = cells.particle_begin(c), end = cells.particle_begin(c + 1);
    const bool admissible = prepare(begin, end);
    const double mean_change = change(begin);
    double shared = 0.;
    bool converged = !admissible;
    for (int iteration = 0; iteration < most_iterations && !converged; ++iteration)
      // at corners of the yield surface full steps may go to and fro
      converged = iterate(begin, end, iteration > 5 ? 0.7 : 1., mean_change, shared);
    for (unsigned int p = begin; p < end; ++p)
    {
      if (!converged) // each for itself
      {
        change(p) = own_change(p);
        answer(p, own_change(p));
        shared = pressure(p) + offset(p);
      }
      cells.volume_factor(p) = admissible ? std::exp((change(p) - own_change(p)) / dim) : 1.;
      cells.pressure(p) = shared;
    }
  }

  /// Starts from the mean volume change. False where a particle is inverted.
  KEDGE_FUNCTION bool prepare(const unsigned int begin, const unsigned int end) const
  {
    double before = 0., after = 0., stress = 0.;
    bool admissible = true;
    for (unsigned int p = begin; p < end; ++p)
    {
      const double J = determinant(matrix_of(particles.trial_deformation, p));
      admissible = admissible && J > 0.;
      const SymmetricTensor b = row_of(particles.elastic_left_cauchy_green, p);
      for (int i = 0; i < 3; ++i)
        strain(p, i) = 0.5 * std::log(particles.trial_frame(p, i));
      own_change(p) = std::log(J);
      offset(p) = start_pressure(p, b);
      before += volume(p);
      after += volume(p) * J;
      stress += volume(p) * offset(p);
    }
    for (unsigned int p = begin; p < end; ++p)
    {
      if (!admissible)
        own_change(p) = 0.;
      change(p) = admissible ? std::log(after / before) : 0.;
      offset(p) -= stress / before;
      cells.spring(p) = least_dilation_modulus * elastic_modulus(begin);
    }
    return admissible;
  }

  /// Of the mean of the dim normal stresses against ln J, Pa.
  KEDGE_FUNCTION double elastic_modulus(const unsigned int p) const
  {
    const HenckyElasticity elasticity = materials(particles.layer(p)).elasticity(particles.young(p));
    return elasticity.lame + 2. * elasticity.shear / dim;
  }

  KEDGE_FUNCTION double start_pressure(const unsigned int p, const SymmetricTensor& b) const
  {
    const HenckyElasticity elasticity = materials(particles.layer(p)).elasticity(particles.young(p));
    const double plane = b[0] * b[1] - b[3] * b[3];
    const double all = b[2] * plane - b[4] * (b[0] * b[4] - b[3] * b[5]) + b[5] * (b[3] * b[4] - b[1] * b[5]);
    return 0.5 * (elasticity.lame * std::log(all) + 2. * elasticity.shear / dim * std::log(dim == 3 ? all : plane));
  }

  /// Finds the pressures for the present volume changes. True if they are one; else changes the volumes by `step`
  /// of Newton's change.
  KEDGE_FUNCTION bool iterate(const unsigned int begin, const unsigned int end, const double step,
                              const double mean_change, double& shared) const
  {
    double missing = 0., weighted = 0., compliance = 0., least = INFINITY, most = -INFINITY, scale = 0.;
    for (unsigned int p = begin; p < end; ++p)
    {
      scale = std::fmax(scale, answer(p, mean_change));
      const double final_volume = volume(p) * std::exp(change(p)), weight = final_volume / modulus(p);
      missing += volume(p) * std::exp(own_change(p)) - final_volume;
      weighted += weight * pressure(p);
      compliance += weight;
      least = std::fmin(least, pressure(p));
      most = std::fmax(most, pressure(p));
    }
    shared = (missing + weighted) / compliance;
    if (most - least <= scale && std::fabs(missing) <= scale * compliance)
      return true;
    for (unsigned int p = begin; p < end; ++p)
      change(p) += step * (shared - pressure(p)) / modulus(p);
    return false;
  }

  /// Sets the pressure and modulus of particle p; returns the accuracy to ask for, Pa.
  KEDGE_FUNCTION double answer(const unsigned int p, const double mean_change) const
  {
    double next_state[Laws::max_state]; // not needed here
    const Material& material = materials(particles.layer(p));
    Eigen::Vector3d trial(strain(p, 0), strain(p, 1), strain(p, 2));
    for (int i = 0; i < dim; ++i)
      trial[i] += (change(p) - own_change(p)) / dim;
    const Response response = respond<true>(trial, {particles.young(p), particles.cell_size(p), &particles.state(p, 0)},
                                            material, next_state);
    double mean = 0., derivative = 0.;
    for (int i = 0; i < dim; ++i)
    {
      mean += response.stress[i] / dim;
      for (int j = 0; j < dim; ++j)
        derivative += response.tangent(i, j) / (dim * dim);
    }
    const double J = std::exp(change(p));
    pressure(p) = mean / J - offset(p) + cells.spring(p) * (change(p) - mean_change);
    modulus(p) = std::fmax(derivative - mean, 0.) / J + cells.spring(p);
    return 1e-10 * elastic_modulus(p) + 1e-9 * std::fabs(mean);
  }
};
} // namespace

template <int dim>
void share_pressure(const ParticleArrays& particles, const StencilSet& stencils, const CellGroups& cells,
                    const Materials& materials)
{
  const std::size_t n = cells.empty() ? 0 : stencils.n_particles;
  const auto number = [&](const std::string& name) { return View<double*>(name, n); };
  Kokkos::parallel_for("share pressure", Kokkos::RangePolicy<ExecutionSpace>(0, cells.n_cells()),
                       SharedPressureKernel<dim>{particles, stencils, cells, materials,
                                                 View<double* [3]>("trial strains", n), number("own volume change"),
                                                 number("offset"), number("volume change"), number("pressure"),
                                                 number("modulus")});
}

template void share_pressure<2>(const ParticleArrays&, const StencilSet&, const CellGroups&, const Materials&);
template void share_pressure<3>(const ParticleArrays&, const StencilSet&, const CellGroups&, const Materials&);
} // namespace kedge
