// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/measure/uncovered_points.h>

#include <deal.II/base/mpi.h>

#include <boost/serialization/utility.hpp>
#include <boost/serialization/vector.hpp>

#include <algorithm>

namespace dovetail {

template <int dim>
nlohmann::ordered_json list_uncovered_points(const Pairing<dim> &pairing, const unsigned int n,
                                             const MPI_Comm &communicator)
{
  std::vector<std::pair<std::vector<double>, unsigned int>> first; // coordinates, side
  for (const auto &point : pairing.uncovered)
    first.push_back({{point.X.begin_raw(), point.X.end_raw()}, point.side});
  const auto keep_first = [&]() {
    std::sort(first.begin(), first.end());
    if (first.size() > n)
      first.resize(n);
  };
  keep_first();
  const auto gathered = dealii::Utilities::MPI::gather(communicator, first);
  first.clear();
  for (const auto &rank_points : gathered)
    first.insert(first.end(), rank_points.begin(), rank_points.end());
  keep_first();
  auto list = nlohmann::ordered_json::array();
  for (const auto &[X, side] : first)
    list.push_back({{"side", side == source ? "source" : "destination"}, {"point", X}});
  return list;
}

template nlohmann::ordered_json list_uncovered_points(const Pairing<2> &, unsigned int, const MPI_Comm &);
template nlohmann::ordered_json list_uncovered_points(const Pairing<3> &, unsigned int, const MPI_Comm &);

} // namespace dovetail
