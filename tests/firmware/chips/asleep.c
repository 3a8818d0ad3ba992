// This program sleeps for ever, so that board time stops exactly at the requested time.
#include "chip.h"

int main(void) { rest(); }
