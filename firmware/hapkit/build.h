// Name of this build, at most 16 characters; the Makefile passes a fingerprint of the sources.
#pragma once

#ifndef HAPKIT_BUILD
#define HAPKIT_BUILD "arduino-ide"
#endif
