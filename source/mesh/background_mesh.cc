#include <deal.II/base/index_set.h>
#include <deal.II/dofs/dof_renumbering.h>
#include <deal.II/dofs/dof_tools.h>
#include <deal.II/fe/fe_q.h>
#include <deal.II/grid/grid_generator.h>
#include <deal.II/grid/grid_tools.h>
#include <deal.II/lac/affine_constraints.h>
#include <kedge/mesh/background_mesh.h>
#include <p4est.h>
#include <unordered_map>

namespace kedge
{
namespace
{
using dealii::types::global_dof_index;

/// True nodes of one leaf in a form that can be sent to other ranks: numbers, positions and weights of every vertex.
struct LeafNodes
{
  std::vector<global_dof_index> ids;
  std::vector<double> positions; ///< dim per node
  std::vector<double> weights;   ///< vertex-major; empty where no vertex hangs

  template <class Archive> void serialize(Archive& archive, const unsigned int) { archive& ids& positions& weights; }
};

template <int dim> using CellRange = typename dealii::DoFHandler<dim>::active_cell_iterator;

/// Replaces the hanging vertices of a leaf by the nodes that they hang on.
template <int dim>
LeafNodes resolve_hanging_vertices(const CellRange<dim>& cell, const dealii::AffineConstraints<double>& constraints,
                                   const std::unordered_map<global_dof_index, dealii::Point<dim>>& master_positions)
{
  constexpr unsigned int n_vertices = 1u << dim;
  std::vector<global_dof_index> vertex_ids(n_vertices);
  cell->get_dof_indices(vertex_ids);

  LeafNodes leaf;
  const auto add_node = [&leaf](const global_dof_index id, const dealii::Point<dim>& position)
  {
    for (unsigned int i = 0; i < leaf.ids.size(); ++i)
      if (leaf.ids[i] == id)
        return i;
    leaf.ids.push_back(id);
    for (unsigned int d = 0; d < dim; ++d)
      leaf.positions.push_back(position[d]);
    return static_cast<unsigned int>(leaf.ids.size() - 1);
  };

  std::vector<std::array<double, 3>> entries; // vertex, node, weight
  for (unsigned int v = 0; v < n_vertices; ++v)
    if (const auto* masters = constraints.get_constraint_entries(vertex_ids[v]))
      for (const auto& [id, weight] : *masters)
        entries.push_back({{double(v), double(add_node(id, master_positions.at(id))), weight}});
    else
      entries.push_back({{double(v), double(add_node(vertex_ids[v], cell->vertex(v))), 1.}});

  // A leaf needs weights unless its nodes are its vertices, in their order.
  bool hanging = leaf.ids.size() != n_vertices;
  for (unsigned int i = 0; !hanging && i < n_vertices; ++i)
    hanging = leaf.ids[i] != vertex_ids[i];
  if (hanging)
  {
    leaf.weights.assign(n_vertices * leaf.ids.size(), 0.);
    for (const auto& [vertex, node, weight] : entries)
      leaf.weights[unsigned(vertex) * leaf.ids.size() + unsigned(node)] += weight;
  }
  return leaf;
}

template <int dim>
std::unordered_map<global_dof_index, dealii::Point<dim>> find_vertex_positions(const dealii::DoFHandler<dim>& nodes)
{
  std::unordered_map<global_dof_index, dealii::Point<dim>> positions;
  std::vector<global_dof_index> ids(1u << dim);
  for (const auto& cell : nodes.active_cell_iterators())
    if (!cell->is_artificial())
    {
      cell->get_dof_indices(ids);
      for (unsigned int v = 0; v < ids.size(); ++v)
        positions.emplace(ids[v], cell->vertex(v));
    }
  return positions;
}

/// Nodes of every owned and ghost leaf, by active cell index. The vertices of a ghost leaf may hang on cells that this
/// rank does not know, so on a mesh with hanging nodes the owners send the nodes of ghosts.
template <int dim>
std::vector<LeafNodes> gather_leaf_nodes(const dealii::DoFHandler<dim>& nodes, const MPI_Comm communicator)
{
  // Which vertices hang, and on which nodes. The nodes' positions are needed only if some vertex hangs.
  dealii::IndexSet relevant;
  dealii::DoFTools::extract_locally_relevant_dofs(nodes, relevant);
  dealii::AffineConstraints<double> constraints(relevant);
  dealii::DoFTools::make_hanging_node_constraints(nodes, constraints);
  constraints.close();
  std::unordered_map<global_dof_index, dealii::Point<dim>> positions;
  if (constraints.n_constraints() > 0)
    positions = find_vertex_positions(nodes);

  // All ranks must agree on whether they exchange nodes.
  const bool any_hanging = dealii::Utilities::MPI::max(unsigned(constraints.n_constraints() > 0), communicator) > 0;
  const bool ask_owners = any_hanging && dealii::Utilities::MPI::n_mpi_processes(communicator) > 1;

  std::vector<LeafNodes> leaf_nodes(nodes.get_triangulation().n_active_cells());
  for (const auto& cell : nodes.active_cell_iterators())
    if (cell->is_locally_owned() || (cell->is_ghost() && !ask_owners))
      leaf_nodes[cell->active_cell_index()] = resolve_hanging_vertices<dim>(cell, constraints, positions);
  if (ask_owners)
    dealii::GridTools::exchange_cell_data_to_ghosts<LeafNodes, dealii::DoFHandler<dim>>(
        nodes, [&](const auto& cell) { return leaf_nodes[cell->active_cell_index()]; },
        [&](const auto& cell, const LeafNodes& received) { leaf_nodes[cell->active_cell_index()] = received; });
  return leaf_nodes;
}

/// Fills the tree, the leaves and the nodes of a leaf table; enters cells in the order in which they are given.
template <int dim> class LeafTableBuilder
{
public:
  using TreeCell = typename dealii::Triangulation<dim>::cell_iterator;

  LeafTableBuilder(LeafTable<dim>& table_, std::vector<unsigned int>& leaf_of_cell_,
                   const std::vector<LeafNodes>& leaf_nodes_, const dealii::IndexSet& owned_nodes_)
      : table(table_), leaf_of_cell(leaf_of_cell_), leaf_nodes(leaf_nodes_), owned_nodes(owned_nodes_)
  {
  }

  /// Enters a cell and all its descendants below an entry of the tree.
  void enter(const TreeCell& cell, const std::size_t entry)
  {
    if (!cell->has_children())
    {
      const typename BackgroundMesh<dim>::Cell leaf(cell);
      if (!leaf->is_artificial())
        enter_leaf(leaf, entry);
      return;
    }
    const std::size_t first = table.tree.size();
    table.tree[entry] = static_cast<std::int32_t>(first);
    table.tree.resize(first + LeafTable<dim>::n_vertices, LeafTable<dim>::unknown);
    for (unsigned int child = 0; child < LeafTable<dim>::n_vertices; ++child)
      enter(cell->child(child), first + child);
  }

private:
  void enter_leaf(const typename BackgroundMesh<dim>::Cell& cell, const std::size_t entry)
  {
    const LeafNodes& source = leaf_nodes[cell->active_cell_index()];
    typename LeafTable<dim>::Leaf leaf;
    for (unsigned int d = 0; d < dim; ++d)
      leaf.lower[d] = cell->vertex(0)[d];
    leaf.size = table.partition.trees().size / double(1u << cell->level());
    leaf.node_begin = table.nodes.size();
    leaf.weight_begin = table.weights.size();
    leaf.n_nodes = source.ids.size();
    leaf.regular = source.weights.empty();
    leaf.owned = cell->is_locally_owned();
    leaf.owner = cell->subdomain_id();
    leaf.tree_level = cell->level();
    leaf.tree_index = cell->index();
    for (unsigned int i = 0; i < source.ids.size(); ++i)
      table.nodes.push_back(number_node(source.ids[i], source.positions.data() + dim * i));
    table.weights.insert(table.weights.end(), source.weights.begin(), source.weights.end());
    leaf_of_cell[cell->active_cell_index()] = table.leaves.size();
    table.tree[entry] = -1 - static_cast<std::int32_t>(table.leaves.size());
    table.leaves.push_back(leaf);
  }

  /// Local number of a node. Nodes are numbered in the order in which leaves name them.
  unsigned int number_node(const global_dof_index id, const double* position)
  {
    const auto [entry, is_new] = local_number.emplace(id, table.node_ids.size());
    if (is_new)
    {
      table.node_ids.push_back(id);
      std::array<double, dim> x;
      std::copy_n(position, dim, x.begin());
      table.node_position.push_back(x);
      table.node_owner_is_me.push_back(owned_nodes.is_element(id));
    }
    return entry->second;
  }

  LeafTable<dim>& table;
  std::vector<unsigned int>& leaf_of_cell;
  const std::vector<LeafNodes>& leaf_nodes;
  const dealii::IndexSet& owned_nodes;
  std::unordered_map<global_dof_index, unsigned int> local_number;
};

template <int dim> typename Partition<dim>::Trees trees_of(const GridLayout<dim>& grid)
{
  typename Partition<dim>::Trees trees;
  for (unsigned int d = 0; d < dim; ++d)
    trees.n[d] = grid.base_cells[d] >> grid.base_level();
  trees.size = std::ldexp(grid.base_size, static_cast<int>(grid.base_level()));
  return trees;
}

template <int dim>
Partition<dim> find_partition(const dealii::parallel::distributed::Triangulation<dim>& forest,
                              const GridLayout<dim>& grid, const MPI_Comm communicator)
{
  const typename Partition<dim>::Trees trees = trees_of<dim>(grid);
  std::vector<std::uint64_t> number_in_forest(forest.n_cells(0));
  std::array<double, dim> corner;
  for (const auto& tree : forest.cell_iterators_on_level(0))
    number_in_forest[trees.find(to_array<dim>(tree->center()), corner)] = tree->id().get_coarse_cell_id();
  ForestPlace first = Partition<dim>::end();
  for (const auto& cell : forest.active_cell_iterators())
    if (cell->is_locally_owned())
      first = std::min(first, place_in_forest(cell->id()));
  return Partition<dim>(trees, std::move(number_in_forest), first, communicator);
}

/// p4est reports every action on standard output unless it is told otherwise, once.
MPI_Comm silence_p4est(const MPI_Comm communicator)
{
  if (sc_package_id < 0)
  {
    sc_init(communicator, 0, 0, nullptr, SC_LP_SILENT);
    p4est_init(nullptr, SC_LP_SILENT);
  }
  return communicator;
}
} // namespace

ForestPlace place_in_forest(const dealii::CellId& id)
{
  ForestPlace place{id.get_coarse_cell_id(), 0}; // of distributed triangulations: the tree's number
  unsigned int digit = ForestPlace::depth;
  for (const std::uint8_t child : id.get_child_indices())
    place.child |= static_cast<std::uint64_t>(child) << 3 * --digit;
  return place;
}

template <int dim>
BackgroundMesh<dim>::BackgroundMesh(MPI_Comm communicator, const GridLayout<dim>& layout)
    : ranks(communicator),
      grid(layout),
      forest(silence_p4est(communicator), dealii::Triangulation<dim>::none,
             dealii::parallel::distributed::Triangulation<dim>::no_automatic_repartitioning),
      nodes(forest)
{
  dealii::Point<dim> upper;
  for (unsigned int d = 0; d < dim; ++d)
    upper[d] = grid.extent(d);
  std::vector<unsigned int> repetitions;
  for (const unsigned int n : grid.base_cells)
    repetitions.push_back(n >> grid.base_level());
  dealii::GridGenerator::subdivided_hyper_rectangle(forest, repetitions, dealii::Point<dim>(), upper);
  for (unsigned int level = 0; level < grid.base_level(); ++level)
  {
    forest.refine_global(1);
    forest.repartition(); // level by level: no rank ever has all cells
  }
  table.window.upper = grid.base_cells;
  update();
}

template <int dim> void BackgroundMesh<dim>::repartition(const std::vector<double>& work)
{
  using CellStatus = typename dealii::parallel::distributed::Triangulation<dim>::CellStatus;
  const auto weigh = [&](const typename dealii::Triangulation<dim>::cell_iterator& cell, CellStatus) -> unsigned int
  { return work.empty() ? 1 : std::lround(10. * work[cell->active_cell_index()]); };
  const boost::signals2::scoped_connection connection(forest.signals.weight.connect(weigh));
  forest.repartition();
}

template <int dim> void BackgroundMesh<dim>::set_window(const Window<dim>& window)
{
  if (window == table.window)
    return;
  table.window = window;
  ++n_changes;
}

template <int dim> void BackgroundMesh<dim>::update()
{
  ++n_changes;
  nodes.distribute_dofs(dealii::FE_Q<dim>(1));
  dealii::DoFRenumbering::hierarchical(nodes); // the order of the cells depends on the history of the mesh
  const std::vector<LeafNodes> leaf_nodes = gather_leaf_nodes(nodes, ranks);

  // A new table with an empty tree; only the window stays.
  const Window<dim> window = table.window;
  table = LeafTable<dim>();
  table.window = window;
  table.base_cells = grid.base_cells;
  table.base_size = grid.base_size;
  table.n_global_nodes = nodes.n_dofs();
  table.n_owned_nodes = nodes.n_locally_owned_dofs();
  table.partition = find_partition<dim>(forest, grid, ranks);
  std::array<double, dim> corner;
  table.tree.assign(forest.n_cells(0), LeafTable<dim>::unknown);
  leaf_of_cell.assign(forest.n_active_cells(), dealii::numbers::invalid_unsigned_int);

  // The forest's trees are the first entries, x fastest, whatever order the forest has them in.
  LeafTableBuilder<dim> builder(table, leaf_of_cell, leaf_nodes, nodes.locally_owned_dofs());
  for (const auto& cell : forest.cell_iterators_on_level(0))
    builder.enter(cell, table.partition.trees().find(to_array<dim>(cell->center()), corner));
}

template class BackgroundMesh<2>;
template class BackgroundMesh<3>;
} // namespace kedge
