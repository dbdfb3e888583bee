#include "domain.h"
#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <kedge/base/exceptions.h>
#include <kedge/materials/material.h>
#include <kedge/particles/generation.h>
#include <limits>

namespace kedge
{
std::vector<ParticleRow> make_rows(const double row_height, const double block_height, const std::vector<Layer>& layers,
                                   const double gravity)
{
  const double sliver = 1e-6 * row_height; // an interface this close to a row's edge counts as on it

  // interfaces[i] is the bottom of layer i
  std::vector<double> interfaces(layers.size(), 0.);
  double level = 0.;
  for (std::size_t i = layers.size() - 1; i > 0; --i)
    interfaces[i - 1] = level += layers[i].thickness;

  std::vector<double> cuts;
  for (unsigned int i = 0; i <= std::lround(block_height / row_height); ++i)
    cuts.push_back(row_height * i);
  for (const double height : interfaces)
    if (std::none_of(cuts.begin(), cuts.end(), [&](const double cut) { return std::abs(cut - height) < sliver; }))
      cuts.push_back(height);
  std::sort(cuts.begin(), cuts.end());

  std::vector<ParticleRow> rows(cuts.size() - 1);
  double stress_at_top = 0.;
  for (std::size_t i = rows.size(); i-- > 0;)
  {
    ParticleRow& row = rows[i];
    row.bottom = cuts[i];
    row.top = cuts[i + 1];
    const double middle = 0.5 * (row.bottom + row.top);
    row.layer = std::find_if(interfaces.begin(), interfaces.end(), [&](const double z) { return middle > z; }) -
                interfaces.begin();
    const double weight = layers[row.layer].material.density * gravity * (row.top - row.bottom);
    row.vertical_stress = stress_at_top + 0.5 * weight;
    stress_at_top += weight;
  }
  return rows;
}

namespace
{
void set_initial_stress(double* data, const unsigned int vertical, const double vertical_stress, const double K0,
                        const double poisson)
{
  // The third axis of plane strain is horizontal too, so every axis but one carries K0 sigma_v.
  const double young = data[field::young];
  double stress[3];
  for (unsigned int d = 0; d < 3; ++d)
    stress[d] = -vertical_stress * (d == vertical ? 1. : K0);
  const double trace = stress[0] + stress[1] + stress[2];
  for (unsigned int d = 0; d < 3; ++d)
  {
    data[field::stress + d] = stress[d];
    data[field::elastic_strain + d] = ((1. + poisson) * stress[d] - poisson * trace) / young;
  }
}

/// The initial stress must leave soil that can be computed: is_sound() in cleaning.cc removes what is not.
void refuse_crushing_stress(const std::vector<ParticleRow>& rows, const MaterialPointParameters& parameters)
{
  for (const ParticleRow& row : rows)
  {
    const MaterialParameters& material = parameters.layers[row.layer].material;
    const double trace = (1. + 2. * *parameters.K0) * row.vertical_stress;
    const double strain = (1. - 2. * material.poisson) * trace / effective_young(material, row.vertical_stress);
    if (!(std::exp(-strain) >= least_volume_ratio))
      throw InputError("material points.layers[" + std::to_string(row.layer) + "].material",
                       fmt::format("under the initial stress, {:.3g} Pa at the height of {:.3g} m, soil of this "
                                   "stiffness has {:.2g} of its volume",
                                   row.vertical_stress, 0.5 * (row.bottom + row.top), std::exp(-strain)),
                       "check the units of \"E\", \"density\" and gravity");
  }
}

template <int dim>
std::vector<ParticleRow> rows_of(const GridLayout<dim>& grid, const MaterialPointParameters& parameters,
                                 const double gravity)
{
  return make_rows(grid.base_size / parameters.points_per_axis, grid.soil_extent[dim - 1], parameters.layers, gravity);
}

/// What all particles of a block have in common.
template <int dim> struct Block
{
  const MaterialPointParameters& parameters;
  double spacing;                        ///< of particles along x and y, m
  std::array<long long, dim> per_axis{}; ///< particles along the horizontal axes
};

/// A particle before it enters the handler.
template <int dim> struct NewParticle
{
  dealii::Point<dim> position;
  long long id; ///< by its place in the block, so that it does not depend on ranks
  std::array<double, field::count> data;
};

/// The particle of a row and of a column of the cell at a corner (m); columns count along x first.
template <int dim>
NewParticle<dim> make_particle(const Block<dim>& block, const dealii::Point<dim>& corner, const ParticleRow& row,
                               const unsigned int row_number, const unsigned int column)
{
  NewParticle<dim> particle;
  double* data = particle.data.data();
  for_each_field([&](const FieldDeclaration& field, const unsigned int offset)
                 { std::fill_n(data + offset, n_components(field.kind), field.initial); });

  // Place and domain: a box as high as the row.
  const unsigned int n = block.parameters.points_per_axis;
  const std::array<unsigned int, 2> along{{column % n, column / n}};
  const double middle = 0.5 * (row.bottom + row.top);
  double volume = row.top - row.bottom;
  particle.id = row_number;
  for (unsigned int d = 0; d < dim - 1; ++d)
  {
    particle.position[d] = corner[d] + block.spacing * (along[d] + 0.5);
    particle.id = particle.id * block.per_axis[d] + std::llround(particle.position[d] / block.spacing - 0.5);
    data[field::half_width + d] = 0.5 * block.spacing;
    volume *= block.spacing;
  }
  particle.position[dim - 1] = middle;
  data[field::half_width + dim - 1] = 0.5 * (row.top - row.bottom);
  for (unsigned int d = 0; d < dim; ++d)
  {
    data[field::initial_position + d] = particle.position[d];
    data[field::initial_half_width + d] = data[field::half_width + d];
  }
  for (unsigned int d = 0; d < 3; ++d)
    data[field::deformation_gradient + 4 * d] = 1.;

  data[field::initial_volume] = volume;
  data[field::mass] = block.parameters.layers[row.layer].material.density * volume;
  data[field::layer] = row.layer;
  return particle;
}
} // namespace

template <int dim>
void generate_particles(ParticleSet<dim>& particles, BackgroundMesh<dim>& mesh,
                        const MaterialPointParameters& parameters, const double gravity)
{
  const GridLayout<dim>& grid = mesh.layout();
  const unsigned int n = parameters.points_per_axis;
  Block<dim> block{parameters, grid.base_size / n, {}};
  for (unsigned int d = 0; d < dim - 1; ++d)
    block.per_axis[d] = (grid.soil_extent[d] > 0. ? std::llround(grid.soil_extent[d] / grid.base_size)
                                                  : static_cast<long long>(grid.base_cells[d])) *
                        n;
  const std::vector<ParticleRow> rows = rows_of(grid, parameters, gravity);
  if (parameters.K0)
    refuse_crushing_stress(rows, parameters);

  double n_places = rows.size();
  for (const long long n_along : block.per_axis)
    n_places *= std::max(1ll, n_along);
  if (n_places > static_cast<double>(std::numeric_limits<dealii::types::particle_index>::max()))
    throw InputError("material points.element size",
                     "the block has more material points than can be numbered, " + std::to_string(n_places),
                     "choose a larger one");

  auto& handler = particles.edit();
  for (const auto& cell : mesh.triangulation().active_cell_iterators())
  {
    if (!cell->is_locally_owned())
      continue;
    const dealii::Point<dim> corner = cell->vertex(0);
    const double size = cell->extent_in_direction(0);
    bool is_beside = false; // the soil
    for (unsigned int d = 0; d < dim - 1; ++d)
      is_beside = is_beside || corner[d] + 0.5 * size > block.per_axis[d] * block.spacing;
    if (is_beside)
      continue;
    for (std::size_t r = 0; r < rows.size(); ++r)
    {
      const double middle = 0.5 * (rows[r].bottom + rows[r].top);
      if (middle <= corner[dim - 1] || middle >= corner[dim - 1] + size)
        continue;
      for (unsigned int column = 0; column < (dim == 3 ? n * n : n); ++column)
      {
        const NewParticle<dim> particle = make_particle(block, corner, rows[r], r, column);
        const dealii::Point<dim> in_cell = mesh.mapping().transform_real_to_unit_cell(cell, particle.position);
        handler.insert_particle(particle.position, in_cell, particle.id, cell,
                                dealii::ArrayView<const double>(particle.data.data(), particle.data.size()));
      }
    }
  }
  handler.update_cached_numbers();
}

template <int dim>
void set_state_at_rest(ParticleSet<dim>& particles, const GridLayout<dim>& grid,
                       const MaterialPointParameters& parameters, const double gravity)
{
  std::vector<Material> materials;
  for (const Layer& layer : parameters.layers)
    materials.push_back(make_material(layer.material));
  const std::vector<ParticleRow> rows = rows_of(grid, parameters, gravity);
  for (auto& particle : particles.edit())
  {
    double* data = particle.get_properties().data();
    const auto layer = static_cast<std::size_t>(data[field::layer]);
    const MaterialParameters& material = parameters.layers[layer].material;
    const double z = particle.get_location()[dim - 1];
    const auto above =
        std::upper_bound(rows.begin() + 1, rows.end(), z,
                         [](const double height, const ParticleRow& row) { return height < row.bottom; });
    const ParticleRow& row = *(above - 1);
    const double vertical_stress =
        row.vertical_stress + material.density * gravity * (0.5 * (row.bottom + row.top) - z);
    data[field::young] = effective_young(material, vertical_stress);
    initialise_state(materials[layer], {grid.soil_extent[dim - 1] - z, vertical_stress}, data + field::law_state);
    if (parameters.K0)
      set_initial_stress(data, dim - 1, vertical_stress, *parameters.K0, material.poisson);
  }
}

#define KEDGE_INSTANTIATE(dim)                                                                                         \
  template void generate_particles<dim>(ParticleSet<dim>&, BackgroundMesh<dim>&, const MaterialPointParameters&,       \
                                        double);                                                                       \
  template void set_state_at_rest<dim>(ParticleSet<dim>&, const GridLayout<dim>&, const MaterialPointParameters&,      \
                                       double);
KEDGE_INSTANTIATE(2)
KEDGE_INSTANTIATE(3)
} // namespace kedge
