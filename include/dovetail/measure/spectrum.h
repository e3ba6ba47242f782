// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Eigenvalues and condition of the matrix that was solved.

#pragma once

#include <dovetail/solve/linear_solver.h>
#include <dovetail/system/block_system.h>

#include <nlohmann/json.hpp>

#include <functional>
#include <string>
#include <vector>

namespace dovetail {

/// For each group of fields that is solved at once, under its name, of its last assembled matrix K without
/// the unknowns that constraints take (hanging, prescribed, tied by constraints: their rows are trivial):
///
///     unknowns                                        n
///     symmetric                                       whether K is
///     smallest eigenvalue, largest eigenvalue         of (K + K^T)/2: K is coercive if the first is positive
///     condition number                                largest over smallest singular value of K
///     scaled smallest eigenvalue, scaled condition number
///                                                     the same of D^-1/2 K D^-1/2, D the diagonal of K; it
///                                                     has no unit, and small ones are exact at any contrast
///     multipliers, negative eigenvalues, smallest absolute eigenvalue
///                                                     only with multipliers: there must be as many negative
///                                                     eigenvalues; for a multiplier D is B diag(A)^-1 B^T
///
/// By LAPACK on the first rank, in O(n^2) memory and O(n^3) time.
///
/// @param[out] left_out sentences about groups that have more than largest_spectrum unknowns.
/// Collective.
template <int dim>
nlohmann::ordered_json measure_spectrum(const BlockSystem<dim> &system, const Numbering &numbering,
                                        const std::vector<SolveGroup> &groups, const MPI_Comm &communicator,
                                        std::vector<std::string> &left_out);

inline constexpr unsigned int largest_spectrum = 4000;

} // namespace dovetail
