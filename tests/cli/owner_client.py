"""A client of an owner's socket (docs/owner-socket.md): one JSON object a line, each way.
  client = OwnerClient(state_folder);   answer = client.ask(order="status")"""
import json
import os
import socket


class OwnerClient:
    def __init__(self, folder):
        self.socket = socket.socket(socket.AF_UNIX)
        self.socket.connect(os.path.join(folder, "owner.sock"))
        self.file = self.socket.makefile("r")

    def say(self, **order):
        self.socket.sendall((json.dumps(order) + "\n").encode())

    def ask(self, **order):
        self.say(**order)
        return json.loads(self.file.readline())
