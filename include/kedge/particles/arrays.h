// Particle data as the kernels see them: plain arrays, one entry per particle of this rank.
#pragma once

#include <kedge/particles/fields.h>
#include <optional>
#include <tuple>

namespace kedge
{
/// The laws' state variables, a row of neighbours in memory for each particle: the laws read and write them in place.
using StateView = Kokkos::View<double * [Laws::max_state], Kokkos::LayoutRight, MemorySpace>;

/// What the kernels read and write, one entry per particle of this rank. Trial data become committed only through
/// ParticleSet::commit.
struct ParticleArrays
{
  std::size_t n = 0;
  View<double* [6]> elastic_left_cauchy_green; ///< committed: exp(2 eps_e)
  View<double*> young, initial_volume, mass;   ///< committed
  View<unsigned int*> layer;                   ///< committed
  View<double*> cell_size;                     ///< edge of the cell in which the particle is, m
  View<double*[3]> velocity, acceleration;     ///< committed, m/s, m/s2
  View<double*[6]> trial_strain, trial_stress; ///< elastic logarithmic strain; Kirchhoff stress, Pa
  View<double*> trial_plastic;                 ///< increment of the equivalent plastic strain
  StateView state, trial_state;                ///< the laws' state variables: committed; at the step's end
  // of the trial increment (assembly/deformation.h)
  View<double* [9]> trial_deformation; ///< dF, without what F-bar adds, column by column
  View<double* [12]> trial_frame;      ///< principal values of dF b dF^T, then their directions, one after the other
};

/// What happens to an array that mirrors a field when a step is committed.
enum class OnCommit
{
  nothing,  ///< it holds what is committed
  replaces, ///< it holds the field at the end of the step, at first as it is committed
  adds      ///< it holds what the step adds, at first nothing
};

/// An array and the field that it mirrors.
template <typename Array> struct MirroredField
{
  Array ParticleArrays::*array;
  unsigned int offset;
  OnCommit on_commit;
};

template <typename Array>
constexpr MirroredField<Array> mirror(Array ParticleArrays::*array, const unsigned int offset,
                                      const OnCommit on_commit = OnCommit::nothing)
{
  return {array, offset, on_commit};
}

/// All fields that the kernels see as they are stored. elastic_left_cauchy_green and cell_size follow from others.
inline constexpr auto mirrored_fields = std::make_tuple(
    mirror(&ParticleArrays::young, field::young), mirror(&ParticleArrays::initial_volume, field::initial_volume),
    mirror(&ParticleArrays::mass, field::mass), mirror(&ParticleArrays::layer, field::layer),
    mirror(&ParticleArrays::velocity, field::velocity), mirror(&ParticleArrays::acceleration, field::acceleration),
    mirror(&ParticleArrays::state, field::law_state),
    mirror(&ParticleArrays::trial_strain, field::elastic_strain, OnCommit::replaces),
    mirror(&ParticleArrays::trial_stress, field::stress, OnCommit::replaces),
    mirror(&ParticleArrays::trial_state, field::law_state, OnCommit::replaces),
    mirror(&ParticleArrays::trial_plastic, field::plastic_strain, OnCommit::adds));

/// What a dynamic step makes of the particles' motion.
struct ParticleMotion
{
  View<double*[3]> velocity_change, acceleration; ///< m/s, m/s2
};

/// Result of a step per particle, for the commit.
struct ParticleIncrements
{
  View<double* [3]> displacement;         ///< m
  View<double* [9]> deformation_gradient; ///< dF of the step
  std::optional<ParticleMotion> motion;   ///< none after a static step, which leaves the particles at rest
};
} // namespace kedge
