#include <algorithm>
#include <cmath>
#include <kedge/base/exceptions.h>
#include <kedge/basis/gimp.h>
#include <numeric>

namespace kedge
{
namespace
{
// Because of round-off, a box that ends on a face may reach slightly across it. Such a sliver would activate nodes
// without stiffness.
constexpr double smallest_overlap = 1e-11;
// Averaging needs a volume, also in the standard MPM: a box this small, relative to the particle's, stands for its
// centre.
constexpr double point_box = 1e-6;

/// Where a leaf's shape functions are taken, and with which weight.
template <int dim> struct Sample
{
  std::array<double, dim> x; ///< m
  double weight;
};

/// Values from one sample and gradients from another. `twist` (1/m) is added to the gradients along each axis with the
/// sign of the product of the vertex's natural coordinates.
template <int dim>
void add_leaf_shape(const LeafTable<dim>& table, const unsigned int leaf_number, const Sample<dim>& of_value,
                    const Sample<dim>& of_gradient, const std::array<double, dim>& twist,
                    std::vector<NodeShare<dim>>& shares)
{
  // Linear functions along each axis, then their products at the vertices.
  constexpr unsigned int n_vertices = LeafTable<dim>::n_vertices;
  const auto& leaf = table.leaves[leaf_number];
  const double inverse_size = 1. / leaf.size;
  double for_value[dim][2], for_gradient[dim][2];
  for (unsigned int d = 0; d < dim; ++d)
  {
    for_value[d][1] = (of_value.x[d] - leaf.lower[d]) * inverse_size;
    for_value[d][0] = 1. - for_value[d][1];
    for_gradient[d][1] = (of_gradient.x[d] - leaf.lower[d]) * inverse_size;
    for_gradient[d][0] = 1. - for_gradient[d][1];
  }

  double vertex_value[n_vertices], vertex_gradient[n_vertices][dim];
  for (unsigned int v = 0; v < n_vertices; ++v)
  {
    vertex_value[v] = of_value.weight;
    double sign = 1.;
    for (unsigned int d = 0; d < dim; ++d)
    {
      vertex_value[v] *= for_value[d][(v >> d) & 1u];
      sign *= (v >> d) & 1u ? 1. : -1.;
    }
    for (unsigned int g = 0; g < dim; ++g)
    {
      double value = (v >> g) & 1u ? inverse_size : -inverse_size;
      for (unsigned int d = 0; d < dim; ++d)
        if (d != g)
          value *= for_gradient[d][(v >> d) & 1u];
      vertex_gradient[v][g] = of_gradient.weight * (value + sign * twist[g]);
    }
  }

  // Hand the vertices' shares to the true nodes; a node may have a share from another leaf already.
  const auto add = [&shares](const unsigned int node, const double factor, const double value, const double* gradient)
  {
    auto share = std::find_if(shares.begin(), shares.end(), [node](const auto& s) { return s.node == node; });
    if (share == shares.end())
      share = shares.insert(shares.end(), NodeShare<dim>{node, 0., {}});
    share->value += factor * value;
    for (unsigned int d = 0; d < dim; ++d)
      share->gradient[d] += factor * gradient[d];
  };
  for (unsigned int n = 0; n < leaf.n_nodes; ++n)
  {
    const unsigned int node = table.nodes[leaf.node_begin + n];
    if (leaf.regular)
      add(node, 1., vertex_value[n], vertex_gradient[n]);
    else
      for (unsigned int v = 0; v < n_vertices; ++v)
        if (const double factor = table.weights[leaf.weight_begin + v * leaf.n_nodes + n]; factor != 0.)
          add(node, factor, vertex_value[v], vertex_gradient[v]);
  }
}
} // namespace

template <int dim>
void add_leaf_shape(const LeafTable<dim>& table, const unsigned int leaf, const std::array<double, dim>& x,
                    const double weight, std::vector<NodeShare<dim>>& shares)
{
  add_leaf_shape<dim>(table, leaf, {x, weight}, {x, weight}, {}, shares);
}

template <int dim> BoxAverage<dim>::BoxAverage(const LeafTable<dim>& table_) : table(table_) {}

template <int dim>
const std::vector<Overlap>& BoxAverage<dim>::find_overlaps(const std::array<double, dim>& centre,
                                                           const std::array<double, dim>& half_width)
{
  for (unsigned int d = 0; d < dim; ++d)
  {
    lower[d] = std::max(table.lower_end(d), centre[d] - half_width[d]);
    upper[d] = std::min(table.upper_end(d), centre[d] + half_width[d]);
  }
  candidates.clear();
  overlaps.clear();
  table.find_leaves(lower, upper, candidates);
  // Volume shared with each leaf, without slivers.
  double box = 1., total = 0.;
  for (unsigned int d = 0; d < dim; ++d)
    box *= upper[d] - lower[d];
  for (const unsigned int candidate : candidates)
  {
    const auto& leaf = table.leaves[candidate];
    double volume = 1.;
    for (unsigned int d = 0; d < dim; ++d)
      volume *= std::min(upper[d], leaf.lower[d] + leaf.size) - std::max(lower[d], leaf.lower[d]);
    if (volume > smallest_overlap * box)
    {
      overlaps.push_back({candidate, volume});
      total += volume;
    }
  }
  for (Overlap& overlap : overlaps)
    overlap.fraction /= total;
  return overlaps;
}

template <int dim> std::array<double, dim> BoxAverage<dim>::middle_of(const Overlap& overlap) const
{
  const auto& leaf = table.leaves[overlap.leaf];
  std::array<double, dim> middle;
  for (unsigned int d = 0; d < dim; ++d)
    middle[d] = 0.5 * (std::min(upper[d], leaf.lower[d] + leaf.size) + std::max(lower[d], leaf.lower[d]));
  return middle;
}

template <int dim>
const std::vector<NodeShare<dim>>& BoxAverage<dim>::average(const std::vector<CellCorrection<dim>>& corrections)
{
  shares.clear();
  factor = 1.;
  if (corrections.empty())
  {
    for (const Overlap& overlap : overlaps)
      add_leaf_shape<dim>(table, overlap.leaf, middle_of(overlap), overlap.fraction, shares);
    return shares;
  }
  factor = 0.;
  for (const Overlap& overlap : overlaps)
  {
    const CellCorrection<dim>& correction = corrections[overlap.leaf];
    const std::array<double, dim> middle = middle_of(overlap);
    const double weight = overlap.fraction * correction.scale;
    add_leaf_shape<dim>(table, overlap.leaf, {middle, overlap.fraction}, {correction.corrected(middle), weight},
                        correction.twist, shares);
    factor += weight;
  }
  for (NodeShare<dim>& share : shares)
    for (double& component : share.gradient)
      component /= factor;
  return shares;
}

template <int dim>
void BoxAverage<dim>::append_to(BoxParts<dim>& parts, const std::vector<CellCorrection<dim>>& corrections) const
{
  for (const Overlap& overlap : overlaps)
  {
    const CellCorrection<dim> correction = corrections.empty() ? CellCorrection<dim>() : corrections[overlap.leaf];
    parts.leaf.push_back(overlap.leaf);
    parts.weight.push_back(overlap.fraction * correction.scale);
    parts.place.push_back(correction.corrected(middle_of(overlap)));
  }
  parts.begin.push_back(parts.leaf.size());
}

template <int dim>
HostStencils build_stencils(const LeafTable<dim>& table, const std::vector<std::array<double, dim>>& centre,
                            const std::vector<std::array<double, dim>>& half_width,
                            const std::vector<unsigned int>& leaf_of_particle, const bool point_basis,
                            const std::vector<CellCorrection<dim>>& corrections, BoxParts<dim>* parts)
{
  if (parts != nullptr)
    parts->begin.assign(1, 0);
  const std::size_t n = centre.size();
  HostStencils stencils;
  stencils.pattern_of_particle.resize(n);
  stencils.value_begin.resize(n + 1, 0);
  stencils.pattern_node_begin.push_back(0);

  BoxAverage<dim> box(table);
  std::vector<std::vector<unsigned int>> pattern_leaves; // of the patterns of the current leaf
  std::size_t first_pattern = 0;                         // of the current leaf
  for (std::size_t p = 0; p < n; ++p)
  {
    // Only particles of one leaf share patterns, so each leaf starts a new list.
    if (p == 0 || leaf_of_particle[p] != leaf_of_particle[p - 1])
    {
      first_pattern = stencils.pattern_node_begin.size() - 1;
      pattern_leaves.clear();
    }
    // The leaves that the box overlaps, and the shares of their nodes.
    std::array<double, dim> size = half_width[p];
    if (point_basis)
      for (double& width : size)
        width *= point_box;
    const std::vector<Overlap>& overlaps = box.find_overlaps(centre[p], size);
    if (overlaps.empty())
      throw SolverError("a material point has left the grid at x = " + std::to_string(centre[p][0]) +
                        " m; a larger domain or smaller steps help");
    const std::vector<NodeShare<dim>>& shares = box.average(corrections);
    stencils.volume_factor.push_back(box.volume_factor());
    if (parts != nullptr)
      box.append_to(*parts, corrections);

    // Boxes that overlap the same leaves have the same nodes: find their pattern, or add it.
    std::size_t k = 0;
    for (; k < pattern_leaves.size(); ++k)
      if (std::equal(pattern_leaves[k].begin(), pattern_leaves[k].end(), overlaps.begin(), overlaps.end(),
                     [](const unsigned int leaf, const Overlap& overlap) { return leaf == overlap.leaf; }))
        break;
    if (k == pattern_leaves.size())
    {
      pattern_leaves.emplace_back();
      for (const Overlap& overlap : overlaps)
        pattern_leaves.back().push_back(overlap.leaf);
      for (const NodeShare<dim>& share : shares)
        stencils.pattern_nodes.push_back(share.node);
      stencils.pattern_node_begin.push_back(stencils.pattern_nodes.size());
    }
    stencils.pattern_of_particle[p] = first_pattern + k;
    for (const NodeShare<dim>& share : shares)
    {
      stencils.value.push_back(share.value);
      stencils.gradient.insert(stencils.gradient.end(), share.gradient.begin(), share.gradient.end());
    }
    stencils.value_begin[p + 1] = stencils.value.size();
  }

  // List the particles of each pattern by a counting sort.
  const std::size_t n_patterns = stencils.pattern_node_begin.size() - 1;
  stencils.pattern_particle_begin.assign(n_patterns + 1, 0);
  for (const unsigned int k : stencils.pattern_of_particle)
    ++stencils.pattern_particle_begin[k + 1];
  std::partial_sum(stencils.pattern_particle_begin.begin(), stencils.pattern_particle_begin.end(),
                   stencils.pattern_particle_begin.begin());
  std::vector<unsigned int> next(stencils.pattern_particle_begin.begin(), stencils.pattern_particle_begin.end());
  stencils.pattern_particles.resize(n);
  for (std::size_t p = 0; p < n; ++p)
    stencils.pattern_particles[next[stencils.pattern_of_particle[p]]++] = p;
  return stencils;
}

template <int dim> StencilSet upload_stencils(HostStencils&& host, const std::vector<unsigned int>& number)
{
  StencilSet set;
  set.dim = dim;
  set.n_particles = host.pattern_of_particle.size();
  set.n_patterns = host.pattern_node_begin.size() - 1;
  for (unsigned int& node : host.pattern_nodes)
    node = number[node];

  // Kernels expect ascending nodes: sort those of each pattern, and the values of its particles in the same order.
  std::vector<unsigned int> order, sorted_nodes;
  std::vector<double> old_value, old_gradient;
  for (std::size_t k = 0; k < set.n_patterns; ++k)
  {
    const unsigned int begin = host.pattern_node_begin[k], n = host.pattern_node_begin[k + 1] - begin;
    set.max_nodes = std::max(set.max_nodes, n);
    unsigned int* nodes = host.pattern_nodes.data() + begin;
    order.resize(n);
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(),
              [&](const unsigned int a, const unsigned int b) { return nodes[a] < nodes[b]; });
    sorted_nodes.clear();
    for (const unsigned int i : order)
      sorted_nodes.push_back(nodes[i]);
    std::copy(sorted_nodes.begin(), sorted_nodes.end(), nodes);
    for (unsigned int i = host.pattern_particle_begin[k]; i < host.pattern_particle_begin[k + 1]; ++i)
    {
      double* value = host.value.data() + host.value_begin[host.pattern_particles[i]];
      double* gradient = host.gradient.data() + dim * host.value_begin[host.pattern_particles[i]];
      old_value.assign(value, value + n);
      old_gradient.assign(gradient, gradient + dim * n);
      for (unsigned int v = 0; v < n; ++v)
      {
        value[v] = old_value[order[v]];
        std::copy_n(old_gradient.data() + dim * order[v], dim, gradient + dim * v);
      }
    }
  }

  set.pattern_node_begin = upload(host.pattern_node_begin, "pattern node begin");
  set.pattern_nodes = upload(host.pattern_nodes, "pattern nodes");
  set.pattern_particle_begin = upload(host.pattern_particle_begin, "pattern particle begin");
  set.pattern_particles = upload(host.pattern_particles, "pattern particles");
  set.pattern_of_particle = upload(host.pattern_of_particle, "pattern of particle");
  set.value_begin = upload(host.value_begin, "value begin");
  set.value = upload(host.value, "S");
  host.gradient.push_back(0.); // kernels read whole SIMD registers
  set.gradient = upload(host.gradient, "grad S");
  set.volume_factor = upload(host.volume_factor, "volume factor");
  return set;
}

template void add_leaf_shape<2>(const LeafTable<2>&, unsigned int, const std::array<double, 2>&, double,
                                std::vector<NodeShare<2>>&);
template void add_leaf_shape<3>(const LeafTable<3>&, unsigned int, const std::array<double, 3>&, double,
                                std::vector<NodeShare<3>>&);
template class BoxAverage<2>;
template class BoxAverage<3>;
template HostStencils build_stencils<2>(const LeafTable<2>&, const std::vector<std::array<double, 2>>&,
                                        const std::vector<std::array<double, 2>>&, const std::vector<unsigned int>&,
                                        bool, const std::vector<CellCorrection<2>>&, BoxParts<2>*);
template HostStencils build_stencils<3>(const LeafTable<3>&, const std::vector<std::array<double, 3>>&,
                                        const std::vector<std::array<double, 3>>&, const std::vector<unsigned int>&,
                                        bool, const std::vector<CellCorrection<3>>&, BoxParts<3>*);
template StencilSet upload_stencils<2>(HostStencils&&, const std::vector<unsigned int>&);
template StencilSet upload_stencils<3>(HostStencils&&, const std::vector<unsigned int>&);
} // namespace kedge
