// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What an interface moves in bodies whose cells are thin beside it.

#pragma once

#include <Epetra_CrsMatrix.h>
#include <Epetra_Vector.h>

#include <memory>

namespace dovetail {

/// What an interface moves: E extends the values on it into the bodies, along lines of strong couplings of A.
/// In thin cells these lead across, and a line minimises its energy by itself: with the couplings c_l and the
/// diagonal D_l of its rows, c_l E_{l-1} + D_l E_l + c_{l+1} E_{l+1} = 0. Elsewhere there are no lines, and
/// only the interface moves.
struct LinesIntoBodies
{
  std::unique_ptr<Epetra_CrsMatrix> transposed; ///< E^T, with the rows and columns of A
  /// Of each line by itself diag(E^T A E), on the interface; elsewhere diag(A).
  Epetra_Vector stiffness;
};

/// @param on_interface positive for the rows of the interface. Collective.
LinesIntoBodies find_lines_into_bodies(const Epetra_CrsMatrix &A, const Epetra_Vector &diagonal,
                                       const Epetra_Vector &on_interface);

} // namespace dovetail
