// The fastest vibration of elastic soil with lumped mass, which limits the time steps of explicit dynamics.
#pragma once

#include <kedge/assembly/acting_points.h>
#include <kedge/assembly/nodal_exchange.h>
#include <kedge/materials/material.h>
#include <kedge/particles/arrays.h>

namespace kedge
{
/// Upper bound of the squared circular frequencies (1/s2) of this rank's soil where node v has the mass m max(S_v,
/// least share) of each particle. No system is faster than its fastest part (Irons & Treharne 1971), so the bound is
/// the largest one of any single particle. A particle with the nodal masses m S_v is bounded by V/m times two largest
/// eigenvalues: that of the elasticity (3 bulk or 2 shear, more under pressure) and that of the sum over nodes of
/// grad S_v (x) grad S_v / S_v.
double bound_squared_frequency(const ParticleArrays& particles, const StencilSet& stencils, const Materials& materials,
                               double least_share);

/// Elastic soil on its nodes and springs that hold it, for small motions from the present state.
struct ElasticSoil
{
  const ParticleArrays& particles;
  const StencilSet& stencils;
  const Materials& materials;
  NodalVector inertia; ///< per local dof, kg; infinite where it is held
  const NodalExchange& exchange;
  std::size_t n_owned;       ///< dofs that this rank owns, the first ones
  std::vector<double> start; ///< per local dof: numbers that have to do with no mode and not with the ranks
  MPI_Comm communicator;
  PointForces points;      ///< where springs hold the soil
  View<double*> stiffness; ///< of the springs, alike in all directions, N/m
};

/// The largest squared circular frequency (1/s2) of all ranks' soil by Lanczos' method: the largest Ritz value plus its
/// residual, by which an eigenvalue may lie above it, and a margin of 5 %. Typically within 5 % after 8 to 16 products,
/// where the bound above gives two or three times as much. Never more than `bound`. Stiffness that F-bar adds is none:
/// a mean of volume changes has less energy than they have. Pressure stiffens. Collective.
template <int dim> double find_squared_frequency(const ElasticSoil& soil, double bound);
} // namespace kedge
