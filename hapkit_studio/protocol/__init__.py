"""The wire between computer and board: messages, framing, codecs, the firmware's header."""
