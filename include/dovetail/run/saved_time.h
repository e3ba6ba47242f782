// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The memory of a time scheme and of the predictor in a checkpoint.

#pragma once

#include <dovetail/output/checkpoint.h>
#include <dovetail/run/predictor.h>
#include <dovetail/time/time_scheme.h>

namespace dovetail {

void save_memory(const TimeMemory &memory, SavedState &to);
TimeMemory saved_memory(const SavedState &from);

/// Those of the last good step.
void save_rates(const Rates &rates, SavedState &to);
Rates saved_rates(const SavedState &from);

void save_predictor(const Predictor &predictor, SavedState &to);
Predictor saved_predictor(const SavedState &from);

} // namespace dovetail
