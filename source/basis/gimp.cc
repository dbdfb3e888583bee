#include <algorithm>
#include <cmath>
#include <kedge/basis/gimp.h>
#include <numeric>

namespace kedge
{
namespace
{
/// Where a leaf's shape functions are taken, and with which weight.
template <int dim> struct Sample
{
  std::array<double, dim> x; ///< m
  double weight;
};

/// Shares of a leaf's vertices, hanging ones included.
template <int dim> struct VertexShares
{
  double value[LeafTable<dim>::n_vertices], gradient[LeafTable<dim>::n_vertices][dim];
};

/// Values from one sample and gradients from another. `twist` (1/m) is added to the gradients along each axis with the
/// sign of the product of the vertex's natural coordinates.
template <int dim>
VertexShares<dim> shares_of_vertices(const typename LeafTable<dim>::Leaf& leaf, const Sample<dim>& of_value,
                                     const Sample<dim>& of_gradient, const std::array<double, dim>& twist)
{
  // Linear functions along each axis, then their products at the vertices.
  const double inverse_size = 1. / leaf.size;
  double for_value[dim][2], for_gradient[dim][2];
  for (unsigned int d = 0; d < dim; ++d)
  {
    for_value[d][1] = (of_value.x[d] - leaf.lower[d]) * inverse_size;
    for_value[d][0] = 1. - for_value[d][1];
    for_gradient[d][1] = (of_gradient.x[d] - leaf.lower[d]) * inverse_size;
    for_gradient[d][0] = 1. - for_gradient[d][1];
  }
  VertexShares<dim> shares;
  for (unsigned int v = 0; v < LeafTable<dim>::n_vertices; ++v)
  {
    shares.value[v] = of_value.weight;
    double sign = 1.;
    for (unsigned int d = 0; d < dim; ++d)
    {
      shares.value[v] *= for_value[d][(v >> d) & 1u];
      sign *= (v >> d) & 1u ? 1. : -1.;
    }
    for (unsigned int g = 0; g < dim; ++g)
    {
      double value = (v >> g) & 1u ? inverse_size : -inverse_size;
      for (unsigned int d = 0; d < dim; ++d)
        if (d != g)
          value *= for_gradient[d][(v >> d) & 1u];
      shares.gradient[v][g] = of_gradient.weight * (value + sign * twist[g]);
    }
  }
  return shares;
}

/// Hands the vertices' shares to the leaf's true nodes: add(n, factor, value, gradient) for its n-th one.
template <int dim, typename Add>
void hand_to_nodes(const LeafTable<dim>& table, const typename LeafTable<dim>::Leaf& leaf,
                   const VertexShares<dim>& shares, const Add& add)
{
  for (unsigned int n = 0; n < leaf.n_nodes; ++n)
    if (leaf.regular)
      add(n, 1., shares.value[n], shares.gradient[n]);
    else
      for (unsigned int v = 0; v < LeafTable<dim>::n_vertices; ++v)
        if (const double factor = table.weights[leaf.weight_begin + v * leaf.n_nodes + n]; factor != 0.)
          add(n, factor, shares.value[v], shares.gradient[v]);
}

/// Finds the patterns of particles: boxes with parts in the same leaves have the same nodes.
template <int dim> class PatternSearch
{
public:
  PatternSearch(const LeafTable<dim>& table_, const BoxParts<dim>& parts_, HostStencils& stencils_)
      : table(table_),
        parts(parts_),
        stencils(stencils_),
        newest(table_.leaves.size(), none),
        mark(table_.node_ids.size(), -1),
        place(mark.size())
  {
    stencils.pattern_node_begin.assign(1, 0);
  }

  /// Number of the pattern of particle p, which is added if it is new.
  unsigned int pattern_of(const std::size_t p)
  {
    const auto leaves = parts.leaf.begin() + parts.begin[p], end = parts.leaf.begin() + parts.begin[p + 1];
    unsigned int& head = newest[*leaves];
    for (unsigned int k = head; k != none; k = older[k])
      if (const auto known = parts.leaf.begin() + parts.begin[model[k]],
          known_end = parts.leaf.begin() + parts.begin[model[k] + 1];
          std::equal(known, known_end, leaves, end))
        return k;
    older.push_back(head);
    head = static_cast<unsigned int>(model.size());
    add(p);
    return head;
  }

  /// By pattern, for the leaves of its parts one after the other: where in the pattern's nodes each of the leaf's is.
  std::vector<unsigned short> slots;
  std::vector<std::size_t> slot_begin;

private:
  static constexpr unsigned int none = -1;

  void add(const std::size_t p)
  {
    std::vector<unsigned int>& nodes = stencils.pattern_nodes;
    const std::size_t begin = nodes.size();
    const int number = static_cast<int>(model.size());
    const auto for_all_nodes = [&](const auto& visit)
    {
      for (std::size_t i = parts.begin[p]; i < parts.begin[p + 1]; ++i)
      {
        const auto& leaf = table.leaves[parts.leaf[i]];
        for (unsigned int n = 0; n < leaf.n_nodes; ++n)
          visit(table.nodes[leaf.node_begin + n]);
      }
    };
    for_all_nodes(
        [&](const unsigned int node)
        {
          if (mark[node] != number)
            nodes.push_back(node);
          mark[node] = number;
        });
    std::sort(nodes.begin() + begin, nodes.end());
    for (std::size_t i = begin; i < nodes.size(); ++i)
      place[nodes[i]] = static_cast<unsigned short>(i - begin);
    slot_begin.push_back(slots.size());
    for_all_nodes([&](const unsigned int node) { slots.push_back(place[node]); });
    stencils.pattern_node_begin.push_back(nodes.size());
    model.push_back(p);
  }

  const LeafTable<dim>& table;
  const BoxParts<dim>& parts;
  HostStencils& stencils;
  std::vector<unsigned int> newest;  ///< by leaf, the last pattern whose first part lies in it
  std::vector<unsigned int> older;   ///< by pattern, the one before with the same leaf of the first part
  std::vector<std::size_t> model;    ///< by pattern, a particle that has it
  std::vector<int> mark;             ///< by node, the last pattern that has it
  std::vector<unsigned short> place; ///< by node, its place in that pattern
};

/// Adds up the shape functions over the parts of a particle's box.
template <int dim> struct AverageKernel
{
  const LeafTable<dim>& table;
  const BoxParts<dim>& parts;
  const std::vector<CellCorrection<dim>>& corrections;
  const PatternSearch<dim>& patterns;
  const HostStencils& stencils;

  void operator()(const std::size_t p) const
  {
    const std::size_t begin = stencils.value_begin[p], n = stencils.value_begin[p + 1] - begin;
    double* value = &stencils.value(begin);
    double* gradient = &stencils.gradient(dim * begin);
    std::fill_n(value, n, 0.);
    std::fill_n(gradient, dim * n, 0.);
    const unsigned short* slot = patterns.slots.data() + patterns.slot_begin[stencils.pattern_of_particle[p]];
    double volume = 0.;
    for (std::size_t i = parts.begin[p]; i < parts.begin[p + 1]; ++i)
    {
      const auto& leaf = table.leaves[parts.leaf[i]];
      const CellCorrection<dim> correction = correction_of<dim>(corrections, parts.leaf[i]);
      const double weight = parts.fraction[i] * correction.scale;
      volume += weight;
      hand_to_nodes<dim>(table, leaf,
                         shares_of_vertices<dim>(leaf, {parts.middle[i], parts.fraction[i]},
                                                 {correction.corrected(parts.middle[i]), weight}, correction.twist),
                         [&](const unsigned int node, const double factor, const double s, const double* ds)
                         {
                           value[slot[node]] += factor * s;
                           for (unsigned int d = 0; d < dim; ++d)
                             gradient[dim * slot[node] + d] += factor * ds[d];
                         });
      slot += leaf.n_nodes;
    }
    stencils.volume_factor(p) = corrections.empty() ? 1. : volume;
    if (!corrections.empty())
      for (std::size_t i = 0; i < dim * n; ++i)
        gradient[i] /= volume;
  }
};

/// Lists the particles of each pattern by a counting sort.
void list_particles(HostStencils& stencils)
{
  const std::size_t n_patterns = stencils.pattern_node_begin.size() - 1;
  stencils.pattern_particle_begin.assign(n_patterns + 1, 0);
  for (const unsigned int k : stencils.pattern_of_particle)
    ++stencils.pattern_particle_begin[k + 1];
  std::partial_sum(stencils.pattern_particle_begin.begin(), stencils.pattern_particle_begin.end(),
                   stencils.pattern_particle_begin.begin());
  std::vector<unsigned int> next(stencils.pattern_particle_begin.begin(), stencils.pattern_particle_begin.end());
  stencils.pattern_particles.resize(stencils.pattern_of_particle.size());
  for (std::size_t p = 0; p < stencils.pattern_of_particle.size(); ++p)
    stencils.pattern_particles[next[stencils.pattern_of_particle[p]]++] = p;
}
} // namespace

template <int dim>
void add_leaf_shape(const LeafTable<dim>& table, const unsigned int number, const std::array<double, dim>& x,
                    const double weight, std::vector<NodeShare<dim>>& shares)
{
  const auto& leaf = table.leaves[number];
  // A node may have a share from another leaf already.
  const auto add = [&](const unsigned int n, const double factor, const double value, const double* gradient)
  {
    const unsigned int node = table.nodes[leaf.node_begin + n];
    auto share = std::find_if(shares.begin(), shares.end(), [node](const auto& s) { return s.node == node; });
    if (share == shares.end())
      share = shares.insert(shares.end(), NodeShare<dim>{node, 0., {}});
    share->value += factor * value;
    for (unsigned int d = 0; d < dim; ++d)
      share->gradient[d] += factor * gradient[d];
  };
  hand_to_nodes<dim>(table, leaf, shares_of_vertices<dim>(leaf, {x, weight}, {x, weight}, {}), add);
}

template <int dim>
void find_leaf_gradients(const LeafTable<dim>& table, const unsigned int number, const std::array<double, dim>& x,
                         std::vector<std::array<double, dim>>& gradients)
{
  const auto& leaf = table.leaves[number];
  gradients.assign(leaf.n_nodes, {});
  hand_to_nodes<dim>(table, leaf, shares_of_vertices<dim>(leaf, {x, 1.}, {x, 1.}, {}),
                     [&](const unsigned int n, const double factor, double, const double* gradient)
                     {
                       for (unsigned int d = 0; d < dim; ++d)
                         gradients[n][d] += factor * gradient[d];
                     });
}

template <int dim>
HostStencils build_stencils(const LeafTable<dim>& table, const BoxParts<dim>& parts,
                            const std::vector<CellCorrection<dim>>& corrections)
{
  const std::size_t n = parts.begin.size() - 1;
  HostStencils stencils;
  stencils.pattern_of_particle.resize(n);
  stencils.value_begin.resize(n + 1, 0);
  PatternSearch<dim> patterns(table, parts, stencils);
  for (std::size_t p = 0; p < n; ++p)
  {
    const unsigned int k = stencils.pattern_of_particle[p] = patterns.pattern_of(p);
    stencils.value_begin[p + 1] =
        stencils.value_begin[p] + stencils.pattern_node_begin[k + 1] - stencils.pattern_node_begin[k];
  }
  const auto uninitialised = [](const char* label)
  { return Kokkos::view_alloc(std::string(label), Kokkos::WithoutInitializing); };
  stencils.value = HostView<double*>(uninitialised("S"), stencils.value_begin[n]);
  stencils.gradient = HostView<double*>(uninitialised("grad S"), dim * stencils.value_begin[n] + 1);
  stencils.gradient(dim * stencils.value_begin[n]) = 0.; // kernels read whole SIMD registers
  stencils.volume_factor = HostView<double*>(uninitialised("volume factor"), n);
  Kokkos::parallel_for("average shape functions", Kokkos::RangePolicy<Kokkos::DefaultHostExecutionSpace>(0, n),
                       AverageKernel<dim>{table, parts, corrections, patterns, stencils});
  list_particles(stencils);
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

  // Kernels expect ascending nodes. Where numbers do not follow the table, sort those of each pattern, and the values
  // of its particles in the same order.
  std::vector<unsigned int> order, sorted_nodes;
  std::vector<double> old_value, old_gradient;
  for (std::size_t k = 0; k < set.n_patterns; ++k)
  {
    const unsigned int begin = host.pattern_node_begin[k], n = host.pattern_node_begin[k + 1] - begin;
    set.max_nodes = std::max(set.max_nodes, n);
    unsigned int* nodes = host.pattern_nodes.data() + begin;
    if (std::is_sorted(nodes, nodes + n))
      continue;
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
      double* value = &host.value(host.value_begin[host.pattern_particles[i]]);
      double* gradient = &host.gradient(dim * host.value_begin[host.pattern_particles[i]]);
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
  set.value = copy_to_device<double>(host.value);
  set.gradient = copy_to_device<double>(host.gradient);
  set.volume_factor = copy_to_device<double>(host.volume_factor);
  return set;
}

#define KEDGE_INSTANTIATE(dim)                                                                                         \
  template void add_leaf_shape<dim>(const LeafTable<dim>&, unsigned int, const std::array<double, dim>&, double,       \
                                    std::vector<NodeShare<dim>>&);                                                     \
  template void find_leaf_gradients<dim>(const LeafTable<dim>&, unsigned int, const std::array<double, dim>&,          \
                                         std::vector<std::array<double, dim>>&);                                       \
  template HostStencils build_stencils<dim>(const LeafTable<dim>&, const BoxParts<dim>&,                               \
                                            const std::vector<CellCorrection<dim>>&);                                  \
  template StencilSet upload_stencils<dim>(HostStencils&&, const std::vector<unsigned int>&);
KEDGE_INSTANTIATE(2)
KEDGE_INSTANTIATE(3)
} // namespace kedge
