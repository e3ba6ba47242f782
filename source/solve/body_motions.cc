// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "body_motions.h"
#include "level_operator.h"

#include <Epetra_Comm.h>
#include <Epetra_MultiVector.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace dovetail {

BodyMotions::BodyMotions(const Epetra_CrsMatrix &A, const std::vector<std::vector<double>> &modes,
                         const std::vector<int> &body_of_row, const std::vector<double> &stiffness)
    : A(A), own_body(body_of_row), body(body_of_row), n_modes(modes.size()),
      n_bodies(static_cast<int>(stiffness.size()))
{
  follow_stiff_bodies(stiffness);
  find_modes(modes);
  find_inverses();
  find_forces();
}

void BodyMotions::follow_stiff_bodies(const std::vector<double> &stiffness)
{
  const double least_ratio = 30, least_share = 0.1;
  Epetra_MultiVector own(A.DomainMap(), 1);
  std::copy(body.begin(), body.end(), own[0]);
  const Epetra_MultiVector seen = at_columns(A, own);
  std::vector<double> sums(n_bodies, 0.);
  for (int row = 0; row < A.NumMyRows(); ++row) {
    int n = 0, *columns = nullptr;
    double *entries = nullptr, sum = 0;
    A.ExtractMyRowView(row, n, entries, columns);
    for (int k = 0; k < n; ++k) {
      sums[static_cast<int>(seen[0][columns[k]])] += std::abs(entries[k]);
      sum += std::abs(entries[k]);
    }
    int leader = body[row];
    double largest = least_share * sum;
    for (int k = 0; k < n; ++k) {
      const int b = static_cast<int>(seen[0][columns[k]]);
      if (sums[b] > largest && stiffness[b] > least_ratio * stiffness[body[row]]) {
        largest = sums[b];
        leader = b;
      }
    }
    for (int k = 0; k < n; ++k)
      sums[static_cast<int>(seen[0][columns[k]])] = 0;
    body[row] = leader;
  }
}

void BodyMotions::find_modes(const std::vector<std::vector<double>> &given)
{
  modes.assign(body.size() * n_modes, 0.);
  for (int row = 0; row < A.NumMyRows(); ++row) {
    int n = 0, *columns = nullptr;
    double *entries = nullptr;
    A.ExtractMyRowView(row, n, entries, columns);
    const auto couples = [&](const int k) { return entries[k] != 0 && A.GCID(columns[k]) != A.GRID(row); };
    bool moves = false;
    for (int k = 0; k < n && !moves; ++k)
      moves = couples(k);
    for (unsigned int m = 0; m < n_modes && moves; ++m)
      modes[row * n_modes + m] = given[m][row];
  }
}

/// In which no motion counts that a body does not have, as the rotation of a single node.
void BodyMotions::find_inverses()
{
  const double least = 1e-12;
  const unsigned int n = n_modes;
  std::vector<double> mine(n_bodies * n * n, 0.), all(mine.size());
  for (unsigned int row = 0; row < body.size(); ++row)
    for (unsigned int i = 0; i < n; ++i)
      for (unsigned int j = 0; j < n; ++j)
        mine[(own_body[row] * n + i) * n + j] += mode(row)[i] * mode(row)[j];
  A.Comm().SumAll(mine.data(), all.data(), static_cast<int>(all.size()));
  inverses.assign(n_bodies, dealii::LAPACKFullMatrix<double>(n));
  for (int b = 0; b < n_bodies; ++b) {
    for (unsigned int i = 0; i < n; ++i)
      for (unsigned int j = 0; j < n; ++j)
        inverses[b](i, j) = all[(b * n + i) * n + j];
    if (inverses[b].linfty_norm() > 0) // else no row of it couples
      inverses[b].compute_inverse_svd(least);
  }
}

void BodyMotions::find_forces()
{
  const double rounding = 4 * std::numeric_limits<double>::epsilon();
  const int n = static_cast<int>(n_modes);
  Epetra_MultiVector own(A.DomainMap(), n + 1);
  for (int row = 0; row < own.MyLength(); ++row) {
    for (int m = 0; m < n; ++m)
      own[m][row] = mode(row)[m];
    own[n][row] = body[row];
  }
  const Epetra_MultiVector seen = at_columns(A, own);
  std::vector<double> sums(n_bodies * n, 0.), sizes(n);
  std::vector<int> others;
  const auto keep = [&](const int row, const int b) {
    forces.push_back({row, b, values.size()});
    values.insert(values.end(), &sums[b * n], &sums[b * n] + n);
  };
  for (int row = 0; row < A.NumMyRows(); ++row) {
    int n_entries = 0, *columns = nullptr;
    double *entries = nullptr;
    A.ExtractMyRowView(row, n_entries, entries, columns);
    others.clear();
    std::fill_n(&sums[body[row] * n], n, 0.);
    std::fill(sizes.begin(), sizes.end(), 0.);
    for (int k = 0; k < n_entries; ++k) {
      const int b = static_cast<int>(seen[n][columns[k]]);
      if (b != body[row] && entries[k] != 0 && std::find(others.begin(), others.end(), b) == others.end()) {
        others.push_back(b);
        std::fill_n(&sums[b * n], n, 0.);
      }
      for (int m = 0; m < n; ++m) {
        const double force = entries[k] * seen[m][columns[k]];
        sums[body[row] * n + m] += force;
        sizes[m] += std::abs(force);
        if (b != body[row])
          sums[b * n + m] += force;
      }
    }
    for (const int b : others)
      keep(row, b);
    bool resists = false;
    for (int m = 0; m < n; ++m) {
      double &sum = sums[body[row] * n + m];
      sum = std::abs(sum) <= rounding * sizes[m] ? 0 : sum;
      resists = resists || sum != 0;
    }
    if (resists)
      keep(row, body[row]);
  }
}

std::vector<double> BodyMotions::motions(const Epetra_Vector &x) const
{
  const unsigned int n = n_modes;
  std::vector<double> mine(n_bodies * n, 0.), all(mine.size());
  for (unsigned int row = 0; row < own_body.size(); ++row)
    for (unsigned int m = 0; m < n; ++m)
      mine[own_body[row] * n + m] += mode(row)[m] * x[row];
  A.Comm().SumAll(mine.data(), all.data(), static_cast<int>(all.size()));
  dealii::Vector<double> sums(n), of_body(n);
  for (int b = 0; b < n_bodies; ++b) {
    std::copy_n(&all[b * n], n, sums.begin());
    inverses[b].vmult(of_body, sums);
    std::copy(of_body.begin(), of_body.end(), &all[b * n]);
  }
  return all;
}

void BodyMotions::multiply(const Epetra_Vector &x, Epetra_Vector &y) const
{
  const unsigned int n = n_modes;
  const std::vector<double> a = motions(x);
  Epetra_Vector rest(x);
  for (unsigned int row = 0; row < body.size(); ++row)
    for (unsigned int m = 0; m < n; ++m)
      rest[row] -= mode(row)[m] * a[body[row] * n + m];
  A.Multiply(false, rest, y);
  for (const Forces &of : forces) {
    const int own = body[of.row];
    for (unsigned int m = 0; m < n; ++m) {
      const double motion = a[of.body * n + m] - (of.body == own ? 0 : a[own * n + m]);
      y[of.row] += values[of.first + m] * motion;
    }
  }
}

} // namespace dovetail
