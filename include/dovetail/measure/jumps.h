// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// How large the jumps of a solution are.

#pragma once

#include <dovetail/scene/note.h>
#include <dovetail/system/model.h>

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace dovetail {

/// Adds to each interface that holds its sides together "relative jump": per field the mean jump (root of the
/// mean square) over the range of the field in the two bodies (largest minus smallest value; of vectors, of
/// the magnitude), from what measure_domains() and measure_interfaces() have found. @return one sentence for
/// each interface at which one is above a hundredth: how large it is, and what to do. Likewise "relative flux
/// gap": the flux of the tie against that in the nearer of the two bodies, worth a sentence above 0.9; and
/// the resultants of ties that do not balance, worth one above a hundredth.
template <int dim>
NoteList explain_jumps(const Model<dim> &model, double t, const nlohmann::ordered_json &domains,
                       const nlohmann::ordered_json &balance, nlohmann::ordered_json &interfaces);

} // namespace dovetail
