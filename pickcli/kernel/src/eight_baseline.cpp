// The hot test for any x86-64.
#define APC_ARCHITECTURE baseline
#include "eight_impl.hpp"
