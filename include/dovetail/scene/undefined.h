// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Laws and formulas that have no value somewhere: what the person who wrote the scene must be told.

#pragma once

#include <dovetail/scene/section.h>

#include <string>

namespace dovetail {

/// Why something has no value at a point.
struct Undefined
{
  std::string reason;             ///< empty: nothing is known to be wrong
  bool is_at_every_state = false; ///< the scene must be changed; else other unknowns may be all right

  explicit operator bool() const { return !reason.empty(); }
};

/// Where a law or a formula leaves the reason before it says that it has no value, and where who asked it
/// finds that: on this rank, of the last one. So the answer itself stays a bool or a number, and nothing is
/// paid where all is well.
Undefined &last_undefined();

/// Leave a reason. @return false, the answer of a law that is not defined: `return undefined("…");`
bool undefined(const std::string &reason, bool is_at_every_state = false);

/// @p value of the formula @p entry at @p X and @p t; leaves the reason if it is no finite number.
template <int dim>
double finite(double value, const Section &section, const std::string &entry, const dealii::Point<dim> &X,
              double t);

/// "PATH, FILE line N: ENTRY MESSAGE"
std::string sentence_about(const Section &section, const std::string &entry, const std::string &message);
std::string in_words(double number, unsigned int n_digits = 4);
/// "(0.1, 0.25)"
template <int dim>
std::string in_words(const dealii::Point<dim> &X, unsigned int n_digits = 4);

/// That of the lowest rank that has one, on all ranks. Collective.
Undefined first_of_ranks(const Undefined &own, const MPI_Comm &communicator);
/// If any rank has one, throw it as a UserError on all ranks. Collective.
void refuse_undefined(const Undefined &own, const MPI_Comm &communicator);
/// An exception that this rank has caught, if any, or else one that another rank has. Collective.
void throw_on_all_ranks(const std::exception_ptr &caught, const MPI_Comm &communicator);

} // namespace dovetail
