// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Products with a matrix whose rounded entries do not resist rigid motions of bodies.

#pragma once

#include <deal.II/lac/lapack_full_matrix.h>

#include <Epetra_CrsMatrix.h>
#include <Epetra_Vector.h>

#include <vector>

namespace dovetail {

/// K x for bodies of which stiff ones move with soft ones. The forces of a body that moves as a rigid one are
/// zero away from supports and ties, but those of rounded entries are u |K| |x|, which may be far more than
/// soft bodies resist. Each body therefore has its motion B a_b, with translations and rotations B about one
/// point for all, and
/// @f[ K x = K \sum_b (x_b - B a_b) + \sum_{b \ne o} K B_b (a_b - a_o) + K B a_o, @f]
/// row by row with the own body o of the row. K B is zero where no support is, and K B_b, of another body,
/// where no tie is. What rounding leaves of the first product adds up to hardly any force on a body. The
/// motions a_b are those of least squares; any others would do. A row of a soft body that leads a stiff one
/// moves with that, and counts as a row of it.
class BodyMotions
{
public:
  /// @p modes: B, [mode][own row]; @p body_of_row: a number from 0 on; @p stiffness: of each body, about.
  /// @p A must stay where it is. Collective.
  BodyMotions(const Epetra_CrsMatrix &A, const std::vector<std::vector<double>> &modes,
              const std::vector<int> &body_of_row, const std::vector<double> &stiffness);

  void multiply(const Epetra_Vector &x, Epetra_Vector &y) const; ///< y = A x; collective

private:
  /// What a motion of a body does to a row, in forces of n_modes unit motions.
  struct Forces
  {
    int row, body; ///< the own one: of all bodies together
    std::size_t first;
  };

  void follow_stiff_bodies(const std::vector<double> &stiffness);
  void find_modes(const std::vector<std::vector<double>> &given);
  void find_inverses();
  void find_forces();
  std::vector<double> motions(const Epetra_Vector &x) const;
  const double *mode(const int row) const { return &modes[static_cast<std::size_t>(row) * n_modes]; }

  const Epetra_CrsMatrix &A;
  const std::vector<int> own_body; ///< of each own row
  std::vector<int> body;           ///< with which it moves
  const unsigned int n_modes;
  const int n_bodies;
  std::vector<double> modes; ///< by own row; zero where a row has but its diagonal
  std::vector<dealii::LAPACKFullMatrix<double>> inverses; ///< of B_b^T B_b, body by body
  std::vector<Forces> forces;
  std::vector<double> values;
};

} // namespace dovetail
