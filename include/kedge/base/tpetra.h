// Aliases of the distributed linear algebra, on the device of kokkos.h.
#pragma once

#include <Tpetra_Core.hpp>
#include <Tpetra_CrsMatrix.hpp>
#include <Tpetra_Map.hpp>
#include <Tpetra_MultiVector.hpp>
#include <Tpetra_Vector.hpp>
#include <kedge/base/kokkos.h>

namespace kedge
{
using LocalOrdinal = int;
using GlobalOrdinal = long long;
using TpetraNode = Tpetra::Map<>::node_type;
using TpetraMap = Tpetra::Map<LocalOrdinal, GlobalOrdinal, TpetraNode>;
using TpetraMatrix = Tpetra::CrsMatrix<double, LocalOrdinal, GlobalOrdinal, TpetraNode>;
using TpetraGraph = TpetraMatrix::crs_graph_type;
using TpetraVector = Tpetra::Vector<double, LocalOrdinal, GlobalOrdinal, TpetraNode>;
using TpetraMultiVector = Tpetra::MultiVector<double, LocalOrdinal, GlobalOrdinal, TpetraNode>;
using TpetraOperator = Tpetra::Operator<double, LocalOrdinal, GlobalOrdinal, TpetraNode>;
using TpetraImport = Tpetra::Import<LocalOrdinal, GlobalOrdinal, TpetraNode>;
} // namespace kedge
