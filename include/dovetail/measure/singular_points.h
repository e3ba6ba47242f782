// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Points at which stresses and heat fluxes have no value: they grow without bound as the mesh is refined.

#pragma once

#include <dovetail/system/model.h>

#include <string>

namespace dovetail {

/// Why the flux of a field is singular at a point, or nothing. The free faces of the joined bodies meet there
/// at more than 225 degrees (a re-entrant corner or edge; Williams 1952), or two materials that are bonded
/// end there at a free face (Bogy 1971): of a scalar only if the interface meets that face at an angle,
/// because with two right angles its flux is regular. Or a prescribed value ends there: of a scalar where the
/// held and the free face meet at more than 114 degrees, of a displacement also in a right angle. Faces are
/// held as conditions of the time @p t say. Collective.
template <int dim>
std::string why_singular(const Model<dim> &model, const dealii::Point<dim> &X, const Field &field, double t);

} // namespace dovetail
