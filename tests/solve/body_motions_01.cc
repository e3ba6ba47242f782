// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Two plane frames of rods, of which one is 1e8 times as stiff as the other one; soft rods lead from one to
// the other. Both move far and turn, and the soft one is strained. The product with their matrix is that of
// the entries, to the rounding of these. The force and the moment on the stiff frame, and the forces on the
// soft one, are those by the elongations of the soft rods in long double. By the entries alone, the force on
// the stiff frame is mere rounding. With a support under the soft frame, its forces count as well.
//
// ranks: 1, 2, 3

#include "../../source/solve/body_motions.h"
#include "../system/scene_model.h"

#include <deal.II/base/mpi.h>

#include <Epetra_MpiComm.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

using namespace dovetail;

namespace {

const int n_across = 6, n_nodes = 2 * n_across * n_across;
const double stiff = 1e8;

int body_of(const int node)
{
  return node / (n_across * n_across);
}

std::array<double, 2> place(const int node)
{
  const int i = node % n_across, j = node / n_across; // the second frame is above the first one
  return {{i + 0.1 * test::noise(node), j + 0.1 * test::noise(7 * node)}};
}

struct Rod
{
  int from, to;
  double stiffness;
  std::array<double, 2> direction{};
};

/// Between nodes that are neighbours, also across.
std::vector<Rod> make_rods()
{
  std::vector<Rod> rods;
  for (int a = 0; a < n_nodes; ++a)
    for (const auto &[di, dj] : {std::pair(1, 0), std::pair(0, 1), std::pair(1, 1), std::pair(-1, 1)}) {
      const int i = a % n_across + di, j = a / n_across + dj, b = j * n_across + i;
      if (i < 0 || i >= n_across || b >= n_nodes)
        continue;
      const auto x = place(a), y = place(b);
      const double length = std::hypot(y[0] - x[0], y[1] - x[1]);
      rods.push_back({a,
                      b,
                      (body_of(a) == 1 && body_of(b) == 1 ? stiff : 1.) * (1.5 + test::noise(3 * a + b)),
                      {{(y[0] - x[0]) / length, (y[1] - x[1]) / length}}});
    }
  return rods;
}

/// K u by elongations.
std::vector<long double> forces(const std::vector<Rod> &rods, const std::vector<double> &u)
{
  std::vector<long double> result(u.size(), 0.);
  for (const Rod &rod : rods) {
    long double elongation = 0;
    for (int c = 0; c < 2; ++c)
      elongation += static_cast<long double>(rod.direction[c]) *
                    (static_cast<long double>(u[2 * rod.to + c]) - u[2 * rod.from + c]);
    for (int c = 0; c < 2; ++c) {
      result[2 * rod.to + c] += rod.stiffness * elongation * rod.direction[c];
      result[2 * rod.from + c] -= rod.stiffness * elongation * rod.direction[c];
    }
  }
  return result;
}

Epetra_CrsMatrix make_matrix(const Epetra_Map &rows, const std::vector<Rod> &rods, const double support)
{
  std::map<std::pair<int, int>, double> entries;
  for (int node = 0; node < n_across; ++node)
    for (int c = 0; c < 2; ++c)
      entries[{2 * node + c, 2 * node + c}] = support;
  for (const Rod &rod : rods)
    for (int c = 0; c < 2; ++c)
      for (int d = 0; d < 2; ++d) {
        const double k = rod.stiffness * rod.direction[c] * rod.direction[d];
        entries[{2 * rod.from + c, 2 * rod.from + d}] += k;
        entries[{2 * rod.to + c, 2 * rod.to + d}] += k;
        entries[{2 * rod.from + c, 2 * rod.to + d}] -= k;
        entries[{2 * rod.to + c, 2 * rod.from + d}] -= k;
      }
  Epetra_CrsMatrix A(Copy, rows, 20);
  for (const auto &[place, value] : entries)
    if (rows.MyGID(place.first))
      A.InsertGlobalValues(place.first, 1, &value, &place.second);
  A.FillComplete(rows, rows);
  return A;
}

/// The force on a frame and its moment, of all ranks.
std::array<double, 3> resultant(const Epetra_Vector &y, const int body)
{
  std::array<double, 3> sum{};
  for (int row = 0; row < y.MyLength(); ++row) {
    const int node = y.Map().GID(row) / 2, c = y.Map().GID(row) % 2;
    if (body_of(node) != body)
      continue;
    sum[c] += y[row];
    sum[2] += c == 0 ? -place(node)[1] * y[row] : place(node)[0] * y[row];
  }
  for (double &of_all : sum)
    of_all = dealii::Utilities::MPI::sum(of_all, MPI_COMM_WORLD);
  return sum;
}

double difference(const std::array<double, 3> &a, const std::array<double, 3> &b)
{
  return std::max({std::abs(a[0] - b[0]), std::abs(a[1] - b[1]), std::abs(a[2] - b[2])});
}

void check(const std::string &name, const double support)
{
  const Epetra_MpiComm communicator(MPI_COMM_WORLD);
  const int p = communicator.NumProc(), rank = communicator.MyPID();
  const Epetra_Map rows(-1, 2 * (n_nodes * (rank + 1) / p - n_nodes * rank / p), 0, communicator);
  const std::vector<Rod> rods = make_rods();
  const Epetra_CrsMatrix A = make_matrix(rows, rods, support);

  std::vector<double> u(2 * n_nodes);
  for (int node = 0; node < n_nodes; ++node) {
    const auto X = place(node);
    const double a = 1e6 / 3, turn = 1e4 / 7; // and the second frame a little more
    u[2 * node] = a - turn * X[1] + (body_of(node) == 0 ? test::noise(5 * node) : 0.3);
    u[2 * node + 1] = 2 * a + turn * X[0] + (body_of(node) == 0 ? test::noise(9 * node) : -0.4);
  }
  const std::vector<long double> exact = forces(rods, u);
  Epetra_Vector x(rows), y(rows), plain(rows), by_rods(rows);
  std::vector<std::vector<double>> modes(3);
  std::vector<int> body;
  for (int row = 0; row < rows.NumMyElements(); ++row) {
    const int i = rows.GID(row), node = i / 2, c = i % 2;
    x[row] = u[i];
    by_rods[row] = static_cast<double>(exact[i] + (node < n_across ? support * u[i] : 0.));
    modes[0].push_back(c == 0 ? 1 : 0);
    modes[1].push_back(c == 1 ? 1 : 0);
    modes[2].push_back(c == 0 ? -place(node)[1] : place(node)[0]);
    body.push_back(body_of(node));
  }
  const BodyMotions motions(A, modes, body, {1, stiff});
  motions.multiply(x, y);
  A.Multiply(false, x, plain);

  // In u, the stiff frame has roundings of 1e-10, which strain its rods. Their forces have no resultant.
  double of_rows = 0, of_soft = 0;
  for (int row = 0; row < y.MyLength(); ++row) {
    of_rows = std::max(of_rows, std::abs(y[row] - plain[row]));
    if (body[row] == 0)
      of_soft = std::max(of_soft, std::abs(y[row] - by_rods[row]));
  }
  const double rounding = std::numeric_limits<double>::epsilon() * 20 * stiff * 1e6;
  test::report(name + ", rows", of_rows, rounding);
  test::report(name + ", forces on the soft frame", of_soft, 1e-7);
  const auto expected = resultant(by_rods, 1), found = resultant(y, 1), of_entries = resultant(plain, 1);
  test::report(name + ", on the stiff frame", difference(found, expected), 1e-5);
  test::report(name + ", on the stiff frame by entries, rounding", difference(of_entries, expected) > 1e-2);
}

} // namespace

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  check("free", 0);
  check("supported", 0.7);
}
