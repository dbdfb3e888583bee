#include <kedge/assembly/nodal_exchange.h>
#include <kedge/base/communication.h>

namespace kedge
{
namespace
{
/// Entries of a vector on the device, as one-dimensional views.
auto read(const TpetraVector& vector)
{
  return Kokkos::subview(vector.getLocalViewDevice(Tpetra::Access::ReadOnly), Kokkos::ALL(), 0);
}

auto overwrite(TpetraVector& vector)
{
  return Kokkos::subview(vector.getLocalViewDevice(Tpetra::Access::OverwriteAll), Kokkos::ALL(), 0);
}
} // namespace

NodalExchange::NodalExchange(const std::size_t n_local_, const Teuchos::RCP<const TpetraMap>& owned,
                             const Teuchos::RCP<const TpetraMap>& local,
                             const Teuchos::RCP<const TpetraImport>& importer_)
    : n_local(n_local_), owned_map(owned), local_map(local), importer(importer_)
{
}

NodalExchange::NodalExchange(const unsigned int dim, const NodeNumbering& numbering)
    : n_local(dim * numbering.global.size()),
      owned_map(make_dof_map(dim, numbering.global, numbering.n_owned)),
      local_map(make_dof_map(dim, numbering.global, numbering.global.size()))
{
  if (size_of(numbering.communicator) > 1)
    importer = Teuchos::rcp(new TpetraImport(owned_map, local_map));
}

NodalVector NodalExchange::make_nodal_vector() const { return NodalVector("nodal vector", n_local); }

NodalVector NodalExchange::spread(const TpetraVector& owned) const
{
  const NodalVector local = make_nodal_vector();
  if (importer.is_null())
  {
    Kokkos::deep_copy(local, read(owned));
    return local;
  }
  TpetraVector all(local_map);
  all.doImport(owned, *importer, Tpetra::INSERT);
  Kokkos::deep_copy(local, read(all));
  return local;
}

void NodalExchange::collect(const NodalVector& local, TpetraVector& owned) const
{
  if (importer.is_null())
  {
    Kokkos::deep_copy(overwrite(owned), local);
    return;
  }
  TpetraVector all(local_map);
  Kokkos::deep_copy(overwrite(all), local);
  owned.putScalar(0.);
  owned.doExport(all, *importer, Tpetra::ADD);
}

void NodalExchange::sum_over_ranks(const NodalVector& local) const
{
  if (importer.is_null())
    return;
  TpetraVector owned(owned_map);
  collect(local, owned);
  TpetraVector all(local_map);
  all.doImport(owned, *importer, Tpetra::INSERT);
  Kokkos::deep_copy(local, read(all));
}
} // namespace kedge
