// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

// Which variants of a study are scenes at all.

#pragma once

#include "scene_of_study.h"

namespace dovetail {

/// All combinations of `Vary`, each checked by `dovetail --check`, and named.
///
/// An entry that a variant does not know, like Theta of a mortar tie, is left out of that variant; variants
/// that are alike then are one. What no variant knows is an error, and so is an input that is wrong in all of
/// them. What is left out, and what is wrong in single ones, is printed.
std::vector<Variant> checked_variants(const SceneOfStudy &scene);

} // namespace dovetail
