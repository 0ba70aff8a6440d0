// Exported functions: plain C functions on C-contiguous arrays, declared in bearing_twin by core.Function.
#pragma once
#include <cstdint>

#define CORE_EXPORT extern "C" [[gnu::visibility("default")]]
