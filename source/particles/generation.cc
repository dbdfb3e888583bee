#include <algorithm>
#include <cmath>
#include <kedge/materials/material.h>
#include <kedge/particles/generation.h>

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
} // namespace

template <int dim>
void generate_particles(ParticleSet<dim>& particles, BackgroundMesh<dim>& mesh,
                        const MaterialPointParameters& parameters, const double gravity)
{
  const GridLayout<dim>& grid = mesh.layout();
  const double spacing = grid.base_size / parameters.points_per_axis;
  const double block_height = grid.soil_extent[dim - 1];
  const std::vector<ParticleRow> rows = make_rows(spacing, block_height, parameters.layers, gravity);
  std::vector<Material> materials;
  for (const Layer& layer : parameters.layers)
    materials.push_back(make_material(layer.material));

  std::array<long long, dim> per_axis;
  for (unsigned int d = 0; d < dim - 1; ++d)
    per_axis[d] = static_cast<long long>(grid.base_cells[d]) * parameters.points_per_axis;

  const unsigned int n_columns =
      dim == 3 ? parameters.points_per_axis * parameters.points_per_axis : parameters.points_per_axis;
  std::vector<double> data(field::count);
  auto& handler = particles.edit();
  for (const auto& cell : mesh.triangulation().active_cell_iterators())
  {
    if (!cell->is_locally_owned())
      continue;
    const dealii::Point<dim> corner = cell->vertex(0);
    const double size = cell->extent_in_direction(0);
    for (std::size_t r = 0; r < rows.size(); ++r)
    {
      const ParticleRow& row = rows[r];
      const double middle = 0.5 * (row.bottom + row.top);
      if (middle <= corner[dim - 1] || middle >= corner[dim - 1] + size)
        continue;
      const MaterialParameters& material = parameters.layers[row.layer].material;
      for (unsigned int column = 0; column < n_columns; ++column)
      {
        for_each_field([&](const FieldDeclaration& field, const unsigned int offset)
                       { std::fill_n(&data[offset], n_components(field.kind), field.initial); });
        dealii::Point<dim> x;
        long long id = r;
        std::array<unsigned int, 2> along{{column % parameters.points_per_axis, column / parameters.points_per_axis}};
        double volume = row.top - row.bottom;
        for (unsigned int d = 0; d < dim - 1; ++d)
        {
          x[d] = corner[d] + spacing * (along[d] + 0.5);
          id = id * per_axis[d] + std::llround(x[d] / spacing - 0.5);
          data[field::half_width + d] = 0.5 * spacing;
          volume *= spacing;
        }
        x[dim - 1] = middle;
        data[field::half_width + dim - 1] = 0.5 * (row.top - row.bottom);
        for (unsigned int d = 0; d < dim; ++d)
        {
          data[field::initial_position + d] = x[d];
          data[field::initial_half_width + d] = data[field::half_width + d];
        }
        for (unsigned int d = 0; d < 3; ++d)
          data[field::deformation_gradient + 4 * d] = 1.;
        data[field::initial_volume] = volume;
        data[field::mass] = material.density * volume;
        data[field::young] = effective_young(material, row.vertical_stress);
        data[field::layer] = row.layer;
        initialise_state(materials[row.layer], {block_height - middle, row.vertical_stress}, &data[field::law_state]);
        if (parameters.K0)
          set_initial_stress(data.data(), dim - 1, row.vertical_stress, *parameters.K0, material.poisson);
        handler.insert_particle(x, mesh.mapping().transform_real_to_unit_cell(cell, x), id, cell,
                                dealii::ArrayView<const double>(data.data(), data.size()));
      }
    }
  }
  handler.update_cached_numbers();
}

template void generate_particles<2>(ParticleSet<2>&, BackgroundMesh<2>&, const MaterialPointParameters&, double);
template void generate_particles<3>(ParticleSet<3>&, BackgroundMesh<3>&, const MaterialPointParameters&, double);
} // namespace kedge
