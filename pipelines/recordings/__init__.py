"""Recordings that come from elsewhere: files of many formats, and the machine they were made on."""
