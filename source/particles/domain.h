// Size of a particle's domain, from its properties.
#pragma once

#include <cmath>
#include <kedge/particles/fields.h>

namespace kedge
{
/// m3 (2-D: m2).
template <int dim> double domain_volume(const double* data)
{
  double volume = 1.;
  for (unsigned int d = 0; d < dim; ++d)
    volume *= 2. * data[field::half_width + d];
  return volume;
}

/// Geometric mean of the edges, m.
template <int dim> double domain_width(const double* data) { return std::pow(domain_volume<dim>(data), 1. / dim); }
} // namespace kedge
