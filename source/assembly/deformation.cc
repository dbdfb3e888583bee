#include <kedge/assembly/deformation.h>
#include <kedge/materials/principal_frames.h>

namespace kedge
{
namespace
{
template <int dim> struct DeformationKernel
{
  ParticleArrays particles;
  StencilSet stencils;
  View<double*> increment;

  static constexpr int width = dim == 3 ? points_together : 1;

  KEDGE_FUNCTION void operator()(const std::size_t batch) const
  {
    const unsigned int first = width * batch, rest = particles.n - first, n = rest < width ? rest : width;
    PrincipalFrames<width> frames;
    bool admissible[width];
    for (unsigned int i = 0; i < width; ++i)
    {
      const unsigned int p = first + (i < n ? i : 0);
      const Eigen::Matrix3d dF = deformation_increment<dim>(stencils, increment, p);
      set_matrix(particles.trial_deformation, p, dF);
      frames.set(i, push_forward(dF, row_of(particles.elastic_left_cauchy_green, p)));
      admissible[i] = determinant(dF) > 0.;
    }
    if constexpr (dim == 3)
      frames.find();
    for (unsigned int i = 0; i < n; ++i)
    {
      const PrincipalFrame frame = dim == 3 ? frames.frame_of(i) : plane_frame(frames.tensor_of(i));
      const unsigned int p = first + i;
      for (int j = 0; j < 3; ++j)
        particles.trial_frame(p, j) = admissible[i] ? frame.values[j] : 0.;
      for (int j = 0; j < 9; ++j)
        particles.trial_frame(p, 3 + j) = frame.directions(j % 3, j / 3);
    }
  }
};
} // namespace

template <int dim>
void deform(const ParticleArrays& particles, const StencilSet& stencils, const View<double*>& increment)
{
  constexpr std::size_t width = DeformationKernel<dim>::width;
  Kokkos::parallel_for("deform", Kokkos::RangePolicy<ExecutionSpace>(0, (particles.n + width - 1) / width),
                       DeformationKernel<dim>{particles, stencils, increment});
}

template void deform<2>(const ParticleArrays&, const StencilSet&, const View<double*>&);
template void deform<3>(const ParticleArrays&, const StencilSet&, const View<double*>&);
} // namespace kedge
