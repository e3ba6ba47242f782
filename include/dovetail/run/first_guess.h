// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A guess from which Newton's method has a long way to go.

#pragma once

#include <dovetail/run/step_control.h>

namespace dovetail {

/// About the Initial of scalar fields in static scenes, if it is further from all values that conditions give
/// than twice their range: a nonlinear field is wherever these are. Without Initial the guess is their mean.
/// Collective.
template <int dim>
NoteList notes_on_first_guess(const Model<dim> &model, const Steps &steps);

} // namespace dovetail
