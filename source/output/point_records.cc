// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/output/bytes.h>
#include <dovetail/output/point_records.h>

#include <deal.II/numerics/rtree.h>

#include <iterator>
#include <limits>
#include <utility>

namespace dovetail {

template <int dim>
std::string PointRecords<dim>::pack(const unsigned int n, const std::vector<double> &numbers) const
{
  std::string bytes;
  for (unsigned int q = 0; q < interface.pairing().n_points(); ++q) {
    for (const unsigned int side : {source, destination})
      for (unsigned int d = 0; d < dim; ++d)
        add_number<double>(interface.pairing().X(side, q)[d], bytes);
    for (unsigned int i = q * n; i < (q + 1) * n; ++i)
      add_number(numbers[i], bytes);
  }
  return bytes;
}

/// Of points at the same place the nearest on the other side, too.
template <int dim>
std::vector<double> PointRecords<dim>::unpack(const unsigned int n, const RecordReader &file,
                                              const std::string &record) const
{
  const double rounding = 1e-8 * interface.sides[source].domain->typical_length();
  const auto &pairing = interface.pairing();
  std::vector<std::pair<dealii::Point<dim>, unsigned int>> numbered;
  for (unsigned int q = 0; q < pairing.n_points(); ++q)
    numbered.emplace_back(pairing.X(source, q), q);
  const auto tree = dealii::pack_rtree(numbered);

  std::vector<double> found(pairing.n_points() * n), row(n);
  std::vector<double> distance(pairing.n_points(), std::numeric_limits<double>::infinity());
  file.for_each_part(record, [&](const std::string &part) {
    for (NumbersOfBytes bytes(part); !bytes.is_at_end();) {
      std::array<dealii::Point<dim>, 2> X;
      for (const unsigned int side : {source, destination})
        for (unsigned int d = 0; d < dim; ++d)
          X[side][d] = bytes.next<double>();
      for (double &number : row)
        number = bytes.next<double>();
      dealii::BoundingBox<dim> box(std::make_pair(X[source], X[source]));
      box.extend(rounding);
      std::vector<typename decltype(tree)::value_type> near;
      tree.query(boost::geometry::index::intersects(box), std::back_inserter(near));
      for (const auto &[own_X, q] : near)
        if (const double sum = own_X.distance(X[source]) + pairing.X(destination, q).distance(X[destination]);
            sum < distance[q] && sum < 2 * rounding) {
          distance[q] = sum;
          std::copy(row.begin(), row.end(), found.begin() + q * n);
        }
    }
  });
  for (const double smallest : distance)
    if (smallest > 2 * rounding)
      return {};
  return found;
}

template class PointRecords<2>;
template class PointRecords<3>;

} // namespace dovetail
