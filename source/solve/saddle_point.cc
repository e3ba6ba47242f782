// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include "saddle_point.h"

#include "level_operator.h"
#include "lines_into_bodies.h"

#include <deal.II/base/mpi.h>

#include <Epetra_Comm.h>
#include <Epetra_Import.h>
#include <Epetra_Map.h>
#include <Epetra_Vector.h>

#include <algorithm>
#include <cmath>

namespace dovetail {

namespace {

/// diag(B diag(A)^-1 B^T)
void add_schur_complement(const Epetra_CrsMatrix &B, const Epetra_Vector &diagonal_of_A,
                          Epetra_Vector &schur_diagonal)
{
  const Epetra_Vector diagonal = at_columns(B, diagonal_of_A);
  for (int i = 0; i < B.NumMyRows(); ++i) {
    int n = 0, *columns = nullptr;
    double *values = nullptr;
    B.ExtractMyRowView(i, n, values, columns);
    for (int k = 0; k < n; ++k)
      if (diagonal[columns[k]] > 0)
        schur_diagonal[i] += values[k] * values[k] / diagonal[columns[k]];
  }
}

} // namespace

void AugmentedBodies::update(const Epetra_CrsMatrix &B, const std::vector<double> &W)
{
  if (R)
    *R = B; // levels that are kept refer to it
  else
    R = std::make_unique<Epetra_CrsMatrix>(B);
  Epetra_Vector root(B.RowMap());
  for (int i = 0; i < root.MyLength(); ++i)
    root[i] = std::sqrt(W[i]);
  R->LeftScale(root);
}

void AugmentedBodies::vmult(GroupVector &destination, const GroupVector &source) const
{
  A.vmult(destination, source);
  Epetra_Vector y(View, destination.trilinos_vector(), 0);
  add_product(*R, Epetra_Vector(View, source.trilinos_vector(), 0), y);
}

void AugmentedBodies::diagonal(GroupVector &destination) const
{
  A.diagonal(destination);
  Epetra_Vector values(View, destination.trilinos_vector(), 0);
  add_diagonal(*R, values);
}

SaddlePoint::SaddlePoint(const BlockMatrix &matrix, const MergedMatrix &all,
                         const std::vector<unsigned int> &bodies,
                         const std::vector<unsigned int> &multipliers,
                         std::vector<MultiplierTraits> given_traits)
    : matrix(matrix), all(all), body_operator(matrix, bodies), augmented(body_operator),
      body_part(matrix.part_of(bodies[0])), multiplier_part(matrix.part_of(multipliers[0])),
      traits(std::move(given_traits))
{
}

const GroupOperator &SaddlePoint::bodies() const
{
  return is_augmented() ? static_cast<const GroupOperator &>(augmented) : body_operator;
}

/// d and, with W = w / d, about the Schur complement of the augmented system,
/// @f[ S'^{-1} = S^{-1} + W - S^{-1} C W \approx (1 + w (1 - C / d)) / d. @f]
void SaddlePoint::update()
{
  const double w_of_pressure = 2; // measured: 0.5 to 4 differ little, 0 doubles the iterations
  const double w_of_tie = 0.3; // more makes oscillations of both sides together too soft beside the diagonal
  const Epetra_CrsMatrix &A = matrix.part(body_part, body_part).trilinos_matrix(),
                         &minus_C = matrix.part(multiplier_part, multiplier_part).trilinos_matrix();
  Epetra_Vector diagonal(A.RowMap()), C(minus_C.RowMap());
  A.ExtractDiagonalCopy(diagonal);
  double sum_of_A = 0;
  diagonal.Norm1(&sum_of_A);
  const double mean = sum_of_A / A.NumGlobalRows();

  minus_C.ExtractDiagonalCopy(C);
  C.Scale(-1.);
  Epetra_Vector d(C);
  const Epetra_CrsMatrix *const B = matrix.has_part(multiplier_part, body_part)
                                        ? &matrix.part(multiplier_part, body_part).trilinos_matrix()
                                        : nullptr;
  if (B != nullptr)
    add_schur_complement(*B, diagonal, d);
  scale.assign(traits.size(), 1.);
  schur.assign(traits.size(), -1.);
  weight.assign(traits.size(), 0.);
  for (unsigned int i = 0; i < traits.size(); ++i)
    if (!traits[i].is_dropped && d[i] > 0) {
      const double w = traits[i].is_of_body ? w_of_pressure : w_of_tie;
      scale[i] = std::sqrt(mean / d[i]);
      schur[i] = mean / (1 + w * (1 - C[i] / d[i]));
      weight[i] = w / d[i];
    }
  if (B == nullptr)
    return;
  augmented.update(*B, weight);
  for (unsigned int i = 0; i < traits.size(); ++i)
    weight[i] /= scale[i] * scale[i];
  factorise_ties(*B, diagonal, C);
}

/// With S_D = C + a B D^-1 B^T, D = diag(E^T A E), it is
/// @f[ \hat S^{-1} = S_D^{-1} (C + a B D^{-1} E^T A E D^{-1} B^T) S_D^{-1}, @f]
/// about the energy of the displacement E D^-1 B^T S_D^-1 g that has the jump g. The traces of oscillating
/// multipliers are small, so that their eigenvalues of S are far below its diagonal, and of those that a soft
/// side does not see, because it is coarser, by the contrast of the sides.
void SaddlePoint::factorise_ties(const Epetra_CrsMatrix &B, const Epetra_Vector &diagonal_of_A,
                                 const Epetra_Vector &C)
{
  const int most = 50000; // they belong to surfaces
  factors.reset();
  of_ties.clear();
  for (unsigned int i = 0; i < traits.size(); ++i)
    if (!traits[i].is_of_body && weight[i] > 0)
      of_ties.push_back(i);
  const Epetra_Map rows(-1, static_cast<int>(of_ties.size()), 0, B.Comm());
  if (rows.NumGlobalElements() == 0 || rows.NumGlobalElements() > most)
    return;
  scale_ties(B, rows);
  Epetra_Vector on_interface(diagonal_of_A.Map());
  add_diagonal(*scaled_ties, on_interface);
  LinesIntoBodies lines = find_lines_into_bodies(matrix.part(body_part, body_part).trilinos_matrix(),
                                                 diagonal_of_A, on_interface);
  extension = std::move(lines.transposed);
  complete_C(C, lines.stiffness);
  root_of_D = std::make_unique<Epetra_Vector>(lines.stiffness);
  for (int i = 0; i < root_of_D->MyLength(); ++i)
    (*root_of_D)[i] = (*root_of_D)[i] > 0 ? std::sqrt(1 / (*root_of_D)[i]) : 0;
  scaled_ties->RightScale(*root_of_D);
  auto S = product_with_transposed(*scaled_ties);
  Epetra_Vector diagonal(scaled_ties->RowMap());
  S->ExtractDiagonalCopy(diagonal);
  for (unsigned int k = 0; k < of_ties.size(); ++k)
    diagonal[k] += added_to_ties[k];
  S->ReplaceDiagonalValues(diagonal);
  factors = std::make_unique<Factors>(std::move(S));
}

/// a^1/2 B, scaled
void SaddlePoint::scale_ties(const Epetra_CrsMatrix &B, const Epetra_Map &rows)
{
  const double share = 1.5; // a: bodies give way beyond the reach of E
  scaled_ties = std::make_unique<Epetra_CrsMatrix>(Copy, rows, 0);
  std::vector<int> global;
  std::vector<double> scaled;
  for (unsigned int k = 0; k < of_ties.size(); ++k) {
    int n = 0, *columns = nullptr;
    double *values = nullptr;
    B.ExtractMyRowView(of_ties[k], n, values, columns);
    global.resize(n);
    scaled.resize(n);
    for (int i = 0; i < n; ++i) {
      global[i] = B.GCID(columns[i]);
      scaled[i] = values[i] * std::sqrt(share) * scale[of_ties[k]];
    }
    scaled_ties->InsertGlobalValues(rows.GID(k), n, scaled.data(), global.data());
  }
  scaled_ties->FillComplete(B.DomainMap(), rows);
}

/// In case that multipliers depend on each other, a thousandth of what the diagonal would be of bodies that
/// are as stiff as the stiffer one is added to C.
void SaddlePoint::complete_C(const Epetra_Vector &C, const Epetra_Vector &stiffness)
{
  const double shift = 1e-3;
  added_to_ties.clear();
  share_of_ties.clear();
  const Epetra_Vector of_columns = at_columns(*scaled_ties, stiffness);
  for (unsigned int k = 0; k < of_ties.size(); ++k) {
    int n = 0, *columns = nullptr;
    double *values = nullptr;
    scaled_ties->ExtractMyRowView(k, n, values, columns);
    double square = 0, stiffest = 0;
    for (int i = 0; i < n; ++i) {
      if (values[i] != 0)
        stiffest = std::max(stiffest, of_columns[columns[i]]);
      square += values[i] * values[i];
    }
    const unsigned int row = of_ties[k];
    const double scaled_C = C[row] * scale[row] * scale[row];
    added_to_ties.push_back(scaled_C + (stiffest > 0 ? shift * square / stiffest : 0));
    share_of_ties.push_back(1 - scaled_C * weight[row]);
  }
}

void SaddlePoint::solve_schur_complement(double *const z, const double *const r) const
{
  for (unsigned int i = 0; i < schur.size(); ++i)
    z[i] = r[i] / schur[i];
  if (!factors)
    return;
  const Epetra_CrsMatrix &A = matrix.part(body_part, body_part).trilinos_matrix();
  Epetra_Vector g(scaled_ties->RowMap()), x(g), u(A.RowMap()), Au(u);
  for (unsigned int k = 0; k < of_ties.size(); ++k)
    g[k] = share_of_ties[k] * r[of_ties[k]];
  factors->solve(x.Values(), g.Values());
  scaled_ties->Multiply(true, x, Au);
  Au.Multiply(1., *root_of_D, Au, 0.);
  extension->Multiply(true, Au, u);
  A.Multiply(false, u, Au);
  extension->Multiply(false, Au, u);
  u.Multiply(1., *root_of_D, u, 0.);
  scaled_ties->Multiply(false, u, g);
  for (unsigned int k = 0; k < of_ties.size(); ++k)
    g[k] += added_to_ties[k] * x[k];
  factors->solve(x.Values(), g.Values());
  for (unsigned int k = 0; k < of_ties.size(); ++k)
    z[of_ties[k]] = x[k] + weight[of_ties[k]] * r[of_ties[k]];
}

void SaddlePoint::scale_multipliers(GroupVector &x) const
{
  double *values = x.trilinos_vector()[0] + body_operator.numbering().n_local();
  for (unsigned int i = 0; i < scale.size(); ++i)
    values[i] *= scale[i];
}

void SaddlePoint::vmult(GroupVector &destination, const GroupVector &source) const
{
  all.vmult(destination, scaled(source));
  scale_multipliers(destination);
}

void SaddlePoint::diagonal(GroupVector &destination) const
{
  all.diagonal(destination);
  scale_multipliers(destination);
  scale_multipliers(destination);
}

} // namespace dovetail
