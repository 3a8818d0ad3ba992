// Sleeps for ever: board time stops exactly where it is told to.
#include "chip.h"

int main(void) { rest(); }
